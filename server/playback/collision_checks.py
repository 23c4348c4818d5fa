"""Collision checks of episodes for replays, by plane geometry, which needs no engine and agrees with every other."""

from collections import OrderedDict

from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.own_furniture import OwnFurniture, furnished
from arramon_server.sim.physics import VariedCollisionCheck
from arramon_server.sim.rules import CollisionCheck
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Section
from arramon_server.sim.variations import SceneDifference

CACHED_SECTIONS = 8
"""Number of sections whose checks are cached."""


class CollisionChecks:
    """Collision checks of sections with episodes' own furniture. Only one thread may use it at a time."""

    def __init__(self) -> None:
        self._kept = OrderedDict[int, tuple[Section, Scene, Footprints]]()

    def of(self, section: Section, furniture: OwnFurniture) -> CollisionCheck:
        """Return the collision check of an episode, from its section and its own furniture."""
        kept = self._kept.pop(id(section), None)
        if kept is None:
            scene = city_scene(section)
            kept = section, scene, Footprints(scene)
        self._kept[id(section)] = kept  # which holds the section, so that no other gets its id
        if len(self._kept) > CACHED_SECTIONS:
            self._kept.popitem(last=False)
        _, scene, footprints = kept
        if furniture.is_empty:
            return footprints
        difference = SceneDifference.between(scene, refurnished(scene, furnished(section, furniture)))
        return VariedCollisionCheck(footprints, difference)
