"""The gate's view of one turn: landmarks and streets by identity, visibility, and the course of the path."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from arramon_client.world import turn_between
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import ACCEPTED_TURNS
from arramon_dataset.paths import PathGeometry, Place
from arramon_dataset.plans.graph import Corner, Junction, Road, StreetGraph
from arramon_server.sim.geometry import Pose

FACING = 35.0
"""Maximum angle between the path and a heading that looks along it, in degrees."""


@dataclass(frozen=True, eq=False)
class GateWorld:
    """The path of a turn, its landmarks and its streets.

    Attributes:
        path: distinct positions of the ground truth.
        start: first pose.
        all_landmarks: those along the path.
        goal: (x, z) of the target.
        graph: the section's streets; None without a plan.
        poses: along the path, to which `Landmark.seen` refers; () to skip the checks of visibility.
    """

    path: Sequence[Place]
    start: Pose
    all_landmarks: Sequence[Landmark]
    goal: Place
    graph: StreetGraph | None
    poses: Sequence[Pose] = ()

    def landmarks(self, identity: str) -> tuple[Landmark, ...]:
        """Return the landmarks of an identity, or of several joined by "+"; openings are left out."""
        return tuple(self._by_identity[each] for each in identity.split("+") if each in self._by_identity)

    @cached_property
    def _by_identity(self) -> dict[str, Landmark]:
        return {landmark.identity: landmark for landmark in self.all_landmarks if landmark.label.kind != "intersection"}

    def of_kinds(self, *kinds: str) -> tuple[Landmark, ...]:
        """Return the landmarks of some kinds, in the order of `all_landmarks`."""
        if kinds not in self._by_kinds:
            self._by_kinds[kinds] = tuple(each for each in self.all_landmarks if each.label.kind in kinds)
        return self._by_kinds[kinds]

    @cached_property
    def _by_kinds(self) -> dict[tuple[str, ...], tuple[Landmark, ...]]:
        return {}

    def junction(self, identity: str) -> Junction | None:
        """Return the junction of an identity, or None."""
        return self._junctions.get(identity)

    @cached_property
    def _junctions(self) -> dict[str, Junction]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.junctions}

    def corner(self, identity: str) -> Corner | None:
        """Return the corner of an identity, or None."""
        return self._corners.get(identity)

    @cached_property
    def _corners(self) -> dict[str, Corner]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.corners}

    def road(self, identity: str) -> Road | None:
        """Return the road of an identity, or None."""
        return self._roads.get(identity)

    @cached_property
    def _roads(self) -> dict[str, Road]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.roads}

    @cached_property
    def geometry(self) -> PathGeometry:
        """Directions and bends of the path."""
        return PathGeometry(self.path, self.start.heading, self.goal)

    def turn_near(self, index: int, degrees: float, reach: int) -> int | None:
        """Return the index within `reach` places of the bend most nearly by `degrees`; None if there is none."""
        low, high = ACCEPTED_TURNS[abs(degrees)]
        found = [
            (abs(abs(angle) - abs(degrees)), at)
            for at, angle in self.geometry.bends.items()
            if abs(at - index) <= reach
            and low <= abs(angle) <= high
            and (abs(degrees) == 180.0 or angle * degrees > 0.0)
        ]
        return min(found)[1] if found else None

    def is_visible(self, landmark: Landmark, first: int, last: int) -> bool:
        """Return whether a landmark is recognised from one of the path's places from `first` to `last`."""
        places = set(self.path[max(first, 0) : last + 1])
        return any(number >= 0 and (self.poses[number].x, self.poses[number].z) in places for number in landmark.seen)

    def is_visible_on(self, landmark: Landmark, index: int) -> bool:
        """Return whether a landmark is recognised from a place of the path while the walker turns to the next place."""
        place, on = self.path[index], self.geometry.heading_after(index)
        return any(
            number >= 0
            and (self.poses[number].x, self.poses[number].z) == place
            and abs(turn_between(self.poses[number].heading, on)) <= FACING
            for number in landmark.seen
        )
