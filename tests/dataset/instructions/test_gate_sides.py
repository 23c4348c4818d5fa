"""Sides of things at bends, and things on zebra crossings: the gate rejects false ones, and none are planned.

The path leads north to a crossing at (0, 0), east to (8, 0), and north again: a turn right, then one left.
"""

from dataclasses import replace
from random import Random
from typing import cast

import pytest

from arramon_dataset.instructions.gate.navigation import NavigationCheck, faults_of_navigation
from arramon_dataset.instructions.gate.sides import is_on_crossing, sides_of
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.navigation.plan import AcceptAllSteps, plan_navigation
from arramon_dataset.instructions.navigation.target import describe_target
from arramon_dataset.instructions.visible_landmarks import Landmark, find_landmarks, poses_along, with_names_as_labels
from arramon_dataset.plans.graph import NamedBuilding, StreetGraph
from arramon_lang.meaning import Navigation, Rotate, Step, Thing, Walk, Where
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import Prop
from tests.dataset.instructions import town
from tests.dataset.instructions.test_gate import WORLD, mark, way
from tests.dataset.instructions.town import thing

NORTH, EAST = 0.0, 90.0
PATH = tuple((x, z - 15.0) for x, z in way(*[NORTH] * 15, *[EAST] * 8, *[NORTH] * 12))
START = Pose(0.0, -15.0, 0.0)
TURNS = Rotate("right"), Rotate("left")


def make_building(x0: float, z0: float, x1: float, z1: float) -> NamedBuilding:
    corners = ((x0, z0), (x0, z1), (x1, z1), (x1, z0))
    return NamedBuilding("building/0", (x0 + x1) / 2, (z0 + z1) / 2, corners, ("red",), "red", "", "", ())


def world(*landmarks: Landmark, building: NamedBuilding | None = None) -> GateWorld:
    buildings = () if building is None else (building,)
    return GateWorld(PATH, START, landmarks, PATH[-1], StreetGraph((), (), (), buildings))


def walk_between_turns(step: Walk, at: GateWorld) -> list[str]:
    """Return the faults of a step between the two turns; those of the turns themselves are not looked at."""
    check = NavigationCheck(at)
    check.add(Walk("to", (Thing("cone", identity="cone/9"),)))
    check.add(TURNS[0])
    return check.add(step)


GUIDE = mark("cone/9", 0.0, 1.0)
RED = Thing("building", look="red", identity="building/0")

BUILDINGS = [
    (make_building(11.0, -4.0, 17.0, 6.0), "right", False),  # Straight ahead, on the right only after the second turn.
    (make_building(11.0, -4.0, 17.0, 6.0), "left", False),
    (make_building(2.0, -9.0, 7.0, -2.0), "right", True),  # Along the street between the turns.
    (make_building(2.0, -9.0, 7.0, -2.0), "left", False),
    (make_building(2.0, 2.0, 6.0, 9.0), "left", True),
    (make_building(10.0, -12.0, 17.0, -3.0), "right", False),  # Ahead on the right, beyond the second turn.
]


@pytest.mark.parametrize(("building", "side", "is_so"), BUILDINGS)
def test_the_side_of_a_building_is_that_before_the_next_turn(building: NamedBuilding, side: str, is_so: bool) -> None:
    middle = mark("building/0", building.corners[0][0], sum(z for _, z in building.corners) / 4, look="red")
    found = walk_between_turns(Walk("past", (RED,), side), world(GUIDE, middle, building=building))
    assert (not found) == is_so, found


POSTS = [
    (4.0, -2.0, "right", True),
    (4.0, -2.0, "left", False),
    (4.0, 2.0, "left", True),
    (10.0, 1.0, "right", False),  # Straight ahead; beside the way after the turn left.
    (11.0, -1.5, "right", False),
    (8.0, -2.0, "right", True),  # Outside the bend, abeam just before it.
    (6.0, 2.0, "left", True),  # Inside it.
    (-2.0, 0.0, "left", False),  # Passed before the turn right.
    (4.0, -0.5, "right", False),  # On the way.
]


@pytest.mark.parametrize(("x", "z", "side", "is_so"), POSTS)
@pytest.mark.parametrize("manner", ["past", "beside"])
def test_the_side_of_a_thing_is_that_before_the_next_turn(
    x: float, z: float, side: str, is_so: bool, manner: str
) -> None:
    found = walk_between_turns(
        Walk(manner, (Thing("tree", identity="tree/0"),), side), world(GUIDE, mark("tree/0", x, z))
    )
    assert (not found) == is_so, found


@pytest.mark.parametrize(
    ("x", "z", "is_so"),
    [(4.0, -2.0, True), (4.0, 2.0, True), (4.0, 0.2, True), (8.5, 0.5, True), (11.0, 1.0, False), (11.0, 4.0, False)],
)
def test_who_passes_a_thing_passes_it_before_the_next_turn(x: float, z: float, is_so: bool) -> None:
    found = walk_between_turns(Walk("past", (Thing("tree", identity="tree/0"),)), world(GUIDE, mark("tree/0", x, z)))
    assert ("tree/0 is not passed before the path bends" not in found) == is_so, found


def test_all_of_several_things_are_on_the_side() -> None:
    two = Thing("tree", number="two", identity="tree/0+tree/1")
    for second, is_so in (((6.0, -2.0), True), ((10.5, -1.0), False)):
        at = world(GUIDE, mark("tree/0", 3.0, -2.0), mark("tree/1", *second))
        found = walk_between_turns(Walk("past", (two,), "right"), at)
        assert ("tree/1 is not on the right" not in found) == is_so, found


@pytest.mark.parametrize(("places", "is_so"), [(((4.0, 2.0), (4.0, -2.0)), True), (((7.0, 1.0), (9.5, -1.0)), False)])
def test_one_walks_between_two_things_by_the_direction_of_the_way_there(
    places: tuple[tuple[float, float], tuple[float, float]], is_so: bool
) -> None:
    """The second two stand on both sides of the mean of the directions before and after the bend alone."""
    two = tuple(Thing("tree", colour, identity=f"tree/{n}") for n, colour in enumerate(("", "")))
    at = world(GUIDE, *(mark(f"tree/{n}", *place) for n, place in enumerate(places)))
    found = walk_between_turns(Walk("between", two), at)
    assert (not any("does not lead between" in each for each in found)) == is_so, found


def test_a_side_is_by_the_way_and_not_by_a_mean_over_a_curve() -> None:
    """The way turns over five places: what is by the part before has a side, what is ahead of it none."""
    path = way(*[NORTH] * 10, 30.0, 30.0, 60.0, 60.0, *[EAST] * 12)
    at = GateWorld(path, Pose(0.0, 0.0, 0.0), (), path[-1], None)
    assert all(right > 0.0 for right in sides_of(at, 0, mark("tree/0", 2.0, 6.0)))
    assert list(sides_of(at, 0, mark("tree/0", 2.0, 6.0)))
    assert not list(sides_of(at, 0, mark("tree/0", 2.5, 18.0)))


ZEBRA = replace(mark("zebra_crossing/0", 12.0, 0.0), heading=EAST)
ON = Thing("zebra_crossing", identity="zebra_crossing/0")


@pytest.mark.parametrize(
    ("x", "z", "is_on"),
    [
        (12.0, 0.0, True), (12.6, 2.0, True), (11.3, -2.2, True), (13.2, 0.0, False), (12.0, 2.7, False),
        (12.0, -2.7, False), (10.5, 1.0, False),
    ],
)  # fmt: skip
@pytest.mark.parametrize("relation", ["near", "left_of", "right_of", "in_front_of", "behind", "against"])
def test_what_stands_on_a_crossing_is_not_next_to_it(x: float, z: float, is_on: bool, relation: str) -> None:
    """The crossing reaches 2.275 units across the street and 0.7 along it, which leads east."""
    mug = replace(mark("collectible/0", x, z), label=SegmentationLabel("mug", "red", "striped"))
    landmarks = (
        *(each for each in WORLD.all_landmarks if each.identity not in ("collectible/0", "zebra_crossing/0")),
        mug,
        ZEBRA,
    )
    target = Thing("mug", "red", "striped", where=(Where(relation, (ON,)),), identity="collectible/0")
    faults = faults_of_navigation(Navigation((), target), replace(WORLD, all_landmarks=landmarks, goal=(x, z)))
    assert is_on_crossing(mug, ZEBRA) == is_on
    assert (f"collectible/0 stands on zebra_crossing/0, not {relation} it" in faults) == is_on, faults


@pytest.mark.parametrize(
    ("relation", "is_so"), [("behind", False), ("right_of", False), ("left_of", True), ("near", True)]
)
def test_the_targets_side_of_a_thing_is_the_same_from_all_of_the_last_places(relation: str, is_so: bool) -> None:
    """The way bends just before the target: one sees it first behind the bench, and last to its left."""
    path = way(*[NORTH] * 10, *[EAST] * 2)
    mug = replace(mark("collectible/0", 3.5, 10.0), label=SegmentationLabel("mug", "red", "striped"))
    at = GateWorld(path, Pose(0.0, 0.0, 0.0), (mug, mark("bench/0", 3.3, 8.2)), (3.5, 10.0), None)
    bench = Thing("bench", identity="bench/0")
    target = Thing("mug", "red", "striped", where=(Where(relation, (bench,)),), identity="collectible/0")
    faults = faults_of_navigation(Navigation((Rotate("right"),), target), at)
    assert (f"collectible/0 is not {relation} bench/0" not in faults) == is_so, faults


# The planner

POSES = [START, *(Pose(x, z, 0.0) for x, z in PATH[1:16])]
NUMBERS = tuple(range(len(POSES)))


def described(target: Collectible, *landmarks: Landmark) -> list[Thing]:
    """Return what forty draws call a target at the end of the first leg."""
    own = Landmark(SegmentationLabel.of(target.type), target.position.x, target.position.z, NUMBERS, 0, "collectible/0")
    seen = [own, *(replace(each, seen=NUMBERS) for each in landmarks)]
    found = (describe_target(target, (target,), seen, POSES, Random(seed)) for seed in range(40))
    return [each for each in found if each is not None]


@pytest.mark.parametrize(("z", "is_named"), [(1.6, False), (3.2, True)])
def test_a_target_on_a_crossing_is_told_by_something_else(z: float, is_named: bool) -> None:
    zebra = replace(mark("zebra_crossing/0", 0.0, 1.2), heading=NORTH)
    wording = described(thing("striped red mug", 0.3, z), zebra, mark("bench/0", 2.4, z))
    names = {where.things[0].kind for each in wording for where in each.where}
    assert ("zebra_crossing" in names) == is_named
    assert "bench" in names


class NoSides(AcceptAllSteps):
    """Refuses every side of what is passed."""

    def after(self, steps: tuple[Step, ...]) -> "NoSides":
        return cast("NoSides", None if any(isinstance(step, Walk) and step.side for step in steps) else self)


def test_a_walk_whose_side_is_refused_is_told_without_it() -> None:
    section = town.crossing(Prop("bench", 2.3, -9.5, 0.0), Prop("hydrant", 5.0, 2.2, 0.0))
    poses = poses_along(town.START, town.PATH, town.ACTIONS)
    landmarks = find_landmarks(poses, town.STREET, section, RasterCamera(with_names_as_labels(city_scene(section))))
    sides = 0
    for seed in range(80):
        wording, refused = (
            plan_navigation(town.PATH, poses, town.STREET[0], town.STREET, landmarks, Random(seed), None, judge)
            for judge in (None, NoSides())
        )
        assert wording is not None
        assert refused is not None
        walks = [step for step in wording.steps if isinstance(step, Walk) and step.way == "past" and step.side]
        if all(step.way == "past" for step in wording.steps if isinstance(step, Walk) and step.side):
            sides += len(walks)
            assert refused.steps == tuple(replace(step, side="") if step in walks else step for step in wording.steps)
    assert sides > 10
