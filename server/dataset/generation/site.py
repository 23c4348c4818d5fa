"""A section with everything that generating episodes in it needs, each part built on first use."""

from collections.abc import Mapping
from functools import cached_property
from typing import Protocol

from server.dataset.generation.draft import Draft
from server.dataset.generation.drawing import DraftSampler
from server.dataset.instructions.sight import identified
from server.dataset.layout.solids import Solids
from server.dataset.plans.graph import StreetGraph
from server.dataset.plans.plan import Plan
from server.dataset.plans.street_graph import street_graph
from server.episodes.episode import Instructions, Turn
from server.sim.cameras import Camera
from server.sim.city import city_scene
from server.sim.geometry import Pose
from server.sim.physics import Physics, physics_of
from server.sim.raster.camera import RasterCamera
from server.sim.scene import Scene
from server.sim.section import Section


class Site:
    """A section with its geometry, physics, camera and sampler. Not thread-safe.

    Attributes:
        section: the section itself.
        plan: the street plan that it was built from; None for a section reconstructed from paths.
    """

    def __init__(self, section: Section, plan: Plan | None = None) -> None:
        self.section, self.plan = section, plan

    @cached_property
    def graph(self) -> StreetGraph | None:
        """The section's street graph; None without a plan."""
        return None if self.plan is None else street_graph(self.plan, self.section)

    @cached_property
    def scene(self) -> Scene:
        """The section's scene."""
        return city_scene(self.section)

    @cached_property
    def solids(self) -> Solids:
        """The section's solids."""
        return Solids.of(self.section)

    @cached_property
    def world(self) -> Physics:
        """The section's physics, the authoritative collision check."""
        return physics_of(self.scene)

    @cached_property
    def camera(self) -> Camera:
        """The section's fast camera."""
        return RasterCamera(self.scene)

    @cached_property
    def sight(self) -> Camera:
        """The section's camera whose labels are the names of bodies, for `sight.find_landmarks`."""
        return RasterCamera(identified(self.scene))

    @cached_property
    def sampler(self) -> DraftSampler:
        """The sampler of drafts in this section."""
        return DraftSampler(self.section)


class Writer(Protocol):
    """Writes the instructions of drafts. All of its random choices are seeded by names, for `randomness.seeded`."""

    def tells(self, start: Pose, turn: Turn, number: int, site: Site, names: tuple[object, ...]) -> bool:
        """Return whether the way of a turn can be told, as far as that is known before its episode is complete.

        Args:
            start: pose at the beginning of the turn.
            turn: of an episode.
            number: 1 or 2.
            site: where it takes place.
            names: those that the episode's instructions will be seeded by.
        """

    def __call__(
        self, draft: Draft, site: Site, names: tuple[object, ...]
    ) -> Mapping[str, tuple[Instructions, Instructions]] | None:
        """Return both turns' instructions in every language; None if no good ones are found: another draft is drawn."""
