"""A section as those who make episodes in it need it: its ground, physics and camera, made when first asked for."""

from collections.abc import Callable, Mapping
from functools import cached_property

from server.episodes.episode import Instructions
from server.episodes.generate.draft import Draft
from server.episodes.generate.drawing import Drawer
from server.episodes.solids import Solids
from server.sim.bullet import Obstacles
from server.sim.cameras import Camera
from server.sim.city import city_scene
from server.sim.raster import RasterCamera
from server.sim.scene import Scene
from server.sim.section import Section


class Site:
    """One section. It belongs to one thread.

    Attributes:
        section: which.
    """

    def __init__(self, section: Section) -> None:
        self.section = section

    @cached_property
    def scene(self) -> Scene:
        """The section's."""
        return city_scene(self.section)

    @cached_property
    def solids(self) -> Solids:
        """What is solid in it."""
        return Solids.of(self.section)

    @cached_property
    def world(self) -> Obstacles:
        """Its physics, which have the last word on what is in the way."""
        return Obstacles(self.scene)

    @cached_property
    def camera(self) -> Camera:
        """The fast one."""
        return RasterCamera(self.scene)

    @cached_property
    def drawer(self) -> Drawer:
        """What draws drafts in it."""
        return Drawer(self.section)


Writer = Callable[[Draft, Site, tuple[object, ...]], Mapping[str, tuple[Instructions, Instructions]] | None]
"""Writes both turns' instructions in every language: given a draft, where it takes place, and the names that draw all
that is left to chance (for `chance.seeded`). None where no good ones are found: the episode is then drawn anew."""
