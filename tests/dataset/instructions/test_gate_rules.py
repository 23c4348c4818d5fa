"""Rules of the gate for navigation, one by one, in the small town of `test_gate`."""

import math
from dataclasses import replace

import pytest

from arramon_dataset.instructions.gate.navigation import NavigationCheck, faults_of_navigation
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.plans.graph import Arm, Corner, Junction, NamedBuilding, Road, StreetGraph
from arramon_lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from tests.dataset.instructions.test_gate import (
    ARMS,
    BARREL,
    BIN,
    CROSSING,
    GRAPH,
    MUG,
    NEAR,
    PLAIN,
    ROADS,
    WORLD,
    mark,
    way,
)

TURN = Rotate("right", "at", CROSSING)


def faults(world: GateWorld, *steps: Step, target: Thing = MUG) -> tuple[str, ...]:
    return faults_of_navigation(Navigation(steps, target), world)


def with_marks(*landmarks: Landmark) -> GateWorld:
    return replace(WORLD, all_landmarks=(*WORLD.all_landmarks, *landmarks))


def seen_all(world: GateWorld) -> GateWorld:
    """The same world, with everything seen from everywhere."""
    poses = tuple(Pose(*place, 0.0) for place in world.path)
    return replace(
        world, poses=poses, all_landmarks=[replace(each, seen=tuple(range(len(poses)))) for each in world.all_landmarks]
    )


@pytest.mark.parametrize(
    ("steps", "fault"),
    [
        ((Face(CROSSING), TURN), "junction/0 is a place: what to face is ambiguous"),
        ((TURN, Rotate("right", "at", CROSSING)), "the path turns only once at its place 15, not twice"),
        ((Walk("along", (Thing("street", identity="street/1"),)), TURN), "street/1 is not on the path"),
        ((TURN, Walk("towards", (BARREL,))), "the path does not lead towards barrel/0"),
        ((Walk("to", (Thing("street_end", identity="junction/0"),)), TURN), "junction/0 is a crossing, not a street_"),
        ((Walk("to", (Thing("square", identity="junction/0"),)), TURN), "junction/0 is a crossing, not a square"),
        (
            (Walk("past", (Thing("building_corner", look="red", identity="corner/0"),)), TURN),
            "corner of a red building",
        ),
    ],
)
def test_a_step_that_is_not_so_is_a_fault(steps: tuple[Step, ...], fault: str) -> None:
    assert any(fault in each for each in faults(WORLD, *steps)), faults(WORLD, *steps)


def test_a_thing_in_the_street_after_a_turn_is_not_what_one_turns_before() -> None:
    world = with_marks(mark("tree/0", 3.0, -1.5))
    turn = Rotate("right", "before", Thing("tree", identity="tree/0"))
    assert "tree/0 lies in the street after the turn" in faults(world, turn)


def test_the_next_of_a_kind_is_the_first_farther_on() -> None:
    between = mark("barrier/2", 2.0, -7.0, "white")
    steps = (
        Walk("past", (NEAR,)),
        Walk("past", (Thing("barrier", "white", which="next", identity="barrier/3"),)),
        TURN,
    )
    far = mark("barrier/3", 2.0, -4.0, "white")

    assert faults(with_marks(far), *steps) == ()
    assert "barrier/3 is not the next of its kind" in faults(with_marks(far, between), *steps)


def test_a_thing_that_one_walks_to_is_the_first_of_its_name_that_is_seen() -> None:
    near, far = mark("kiosk/1", 1.0, -8.0, "red"), mark("kiosk/2", 1.0, -2.0, "red")
    steps = (Walk("past", (Thing("kiosk", "red", identity="kiosk/2"),)), TURN)

    assert "kiosk/1 may be taken for kiosk/2" in faults(seen_all(with_marks(near, far)), *steps)
    blue = replace(near, label=replace(near.label, colour="blue"))
    assert faults(seen_all(with_marks(blue, far)), *steps) == ()
    alone = seen_all(with_marks(far))
    for glimpsed, fault in ((None, ()), (3, ("the path passes kiosk/1 before kiosk/2",))):
        world = replace(alone, all_landmarks=(*alone.all_landmarks, replace(near, seen=(), glimpsed=glimpsed)))
        assert faults(world, *steps) == fault


def test_a_zebra_crossing_beside_the_way_makes_counting_doubtful() -> None:
    first, second = mark("zebra_crossing/1", 0.0, -11.0), mark("zebra_crossing/2", 0.5, -5.0)
    steps = (Walk("to", (Thing("zebra_crossing", which="second", identity="zebra_crossing/2"),)), TURN)

    assert faults(with_marks(first, second), *steps) == ()
    for x in (2.5, 4.0):
        beside = mark("zebra_crossing/3", x, -8.0)
        fault = "zebra_crossing/3 lies beside the way to zebra_crossing/2, and may be counted"
        assert fault in faults(with_marks(first, second, beside), *steps)


@pytest.mark.parametrize(("x", "is_fault"), [(0.5, False), (2.0, False), (4.0, True)])
def test_one_who_walks_to_a_thing_turns_there_and_not_short_of_it(x: float, is_fault: bool) -> None:
    """The path turns right at its place 15, where x = 0, and goes on along x."""
    check = NavigationCheck(with_marks(mark("tree/3", x, 1.0)))
    check.add(Walk("to", (Thing("tree", identity="tree/3"),)))
    found = check.add(Rotate("right"))
    assert ("the path turns right before it reaches the thing to walk to" in found) == is_fault, found


def test_who_turns_left_does_not_turn_left_again_at_once() -> None:
    for headings, is_fault in (((-60.0, -60.0, -123.0), True), ((-90.0,), False), ((-60.0, -90.0), False)):
        path = way(*headings, *[headings[-1]] * 14)
        found = faults(GateWorld(path, Pose(0.0, 0.0, 0.0), (), path[-1], None), Rotate("left"), target=PLAIN)
        assert ("the path turns again soon after its place 0, which is not mentioned" in found) == is_fault, found


def test_a_dumpster_is_taken_for_a_bin() -> None:
    dumpster, own = mark("dumpster/0", 1.0, -8.0, "green"), mark("bin/5", 1.0, -2.0)
    steps = (Walk("past", (Thing("bin", identity="bin/5"),)), TURN)

    assert "dumpster/0 may be taken for bin/5" in faults(seen_all(with_marks(dumpster, own)), *steps)
    tree = replace(dumpster, label=SegmentationLabel("tree"), identity="tree/3")
    assert "tree/3 may be taken for bin/5" not in faults(seen_all(with_marks(tree, own)), *steps)


@pytest.mark.parametrize(
    ("places", "is_seen"), [((10, 11), True), ((5,), True), ((1, 2), False), ((), False), ((12, 20), True)]
)
def test_a_thing_is_seen_shortly_before_one_comes_to_it(places: tuple[int, ...], is_seen: bool) -> None:
    """The path comes by at its place 13: who sees the thing only from far off sees it across a corner."""
    world = seen_all(with_marks(mark("tree/3", 2.0, -2.0)))
    world = replace(world, all_landmarks=(*world.all_landmarks[:-1], replace(world.all_landmarks[-1], seen=places)))
    found = faults(world, Walk("past", (Thing("tree", identity="tree/3"),)), TURN)
    assert ("tree/3 cannot be seen on the way to it" not in found) == is_seen, found


@pytest.mark.parametrize(("degrees", "is_told"), [(30.0, False), (36.0, False), (45.0, True)])
def test_a_bend_that_is_more_than_slight_is_told(degrees: float, is_told: bool) -> None:
    path = way(*[0.0] * 15, *[degrees] * 15)
    found = faults(GateWorld(path, Pose(0.0, 0.0, 0.0), (), path[-1], None), target=PLAIN)
    assert any("which is not mentioned" in each for each in found) == is_told, found


def test_one_turns_before_or_after_a_thing_where_no_other_street_opens() -> None:
    side = Junction("junction/1", 0.0, -8.0, "t_junction", (ARMS[0], ARMS[1], ARMS[2]), 2.0)
    roads = (*ROADS, Road("street/2", "Side", "street", 4.0, ((0.0, -8.0), (20.0, -8.0)), ("junction/1",)))
    world = replace(WORLD, graph=StreetGraph((*GRAPH.junctions, side), roads, (), ()))
    after = Rotate("right", "after", replace(BIN, identity="bin/0"))
    close = Rotate("right", "after", Thing("bench", number="two", identity="bench/0+bench/1"))

    found = faults(world, replace(after, thing=Thing("kiosk", identity="kiosk/7")), target=PLAIN)
    assert any("does not turn right after kiosk/7" in each for each in found)
    assert faults(world, close) == ()
    before = replace(close, at="before", thing=Thing("tree", identity="tree/1"))
    beyond = replace(world, all_landmarks=(*world.all_landmarks, mark("tree/1", -2.0, 3.0)))
    assert "one may turn right at junction/1 street/1, before tree/1" not in faults(beyond, before)
    first = replace(beyond, path=[(0.0, float(z)) for z in range(-15, -8)] + [(float(x), -8.0) for x in range(1, 9)])
    turn = Rotate("right", "before", Thing("barrel", "red", identity="barrel/0"))
    assert not any("one may turn" in each for each in faults(first, turn, target=PLAIN))


def test_a_turn_on_the_way_towards_a_thing_is_the_first_that_one_may_make() -> None:
    side = Junction("junction/1", 0.0, -8.0, "t_junction", (ARMS[0], ARMS[1], ARMS[2]), 2.0)
    roads = (*ROADS, Road("street/2", "Side", "street", 4.0, ((0.0, -8.0), (20.0, -8.0)), ("junction/1",)))
    tree = mark("tree/0", 0.5, 4.0)
    steps = (Walk("towards", (Thing("tree", identity="tree/0"),)), Rotate("right"))
    plain = with_marks(tree)
    crossed = replace(plain, graph=StreetGraph((*GRAPH.junctions, side), roads, (), ()))

    assert faults(plain, *steps) == ()
    assert "one may turn right before the path's place 15" in faults(crossed, *steps)
    assert not any("one may turn" in each for each in faults(crossed, Walk("to", steps[0].things), steps[1]))


def test_who_turns_looks_along_the_way_and_not_into_another_street() -> None:
    """The way leads on 150 degrees from where one faced; a street that one looks into after a turn around is nearer."""
    heading = math.radians(150.0)
    path = tuple((step * math.sin(heading), 1.0 + step * math.cos(heading)) for step in range(12))
    beside = Arm(200.0, "street/1", "", -1.0, -3.0)
    for arms, is_clear in (((ARMS[0],), True), ((ARMS[0], beside), False)):
        graph = StreetGraph((Junction("junction/0", 0.0, 0.0, "fork", arms, 3.0),), ROADS, (), ())
        found = faults(GateWorld(path, Pose(0.0, 1.0, 0.0), (), path[-1], graph), Rotate("around"), target=PLAIN)
        assert ("one may turn into street/1 at junction/0 instead" not in found) == is_clear, found


def test_a_corner_of_a_building_is_the_first_of_that_look() -> None:
    def house(number: int, z: float) -> NamedBuilding:
        corners = ((-4.0, z), (-4.0, z + 4.0), (-9.0, z + 4.0), (-9.0, z))
        return NamedBuilding(f"building/{number}", -6.5, z + 2.0, corners, ("red",), "brick", "", "", ())

    here = Corner("corner/0", -4.0, -3.0, "junction/0", "building/0")
    own, other = house(0, -7.0), house(1, -14.0)
    landmarks = (mark("building/0", -4.0, -5.0, look="brick"), mark("building/1", -4.0, -12.0, look="brick"))
    walk = Walk("to", (Thing("building_corner", look="brick", identity="corner/0"),))
    for buildings, is_first in (((own,), True), ((own, other), False)):
        graph = StreetGraph(GRAPH.junctions, ROADS, (here,), buildings)
        found = faults(replace(with_marks(*landmarks), graph=graph), walk, TURN)
        assert ("a corner of building/1 comes before corner/0" not in found) == is_first, found


def test_a_judge_of_a_plan_goes_on_step_by_step() -> None:
    check = NavigationCheck(WORLD)
    past = check.after((Walk("past", (NEAR,)),))

    assert past is not None
    assert past.after((Walk("past", (replace(NEAR, kind="bench"),)),)) is None
    assert not past.may_end(MUG)  # No step mentions the bend at the crossing.
    turned = past.after((TURN,))
    assert turned is not None
    assert turned.may_end(MUG)
    assert check.after((Rotate("left"),)) is None
    assert past.after((Walk("to", (Thing("cone", identity="cone/0"),), straight=False),)) is not None
    goal = Walk("to", (replace(MUG, where=()),), straight=False)
    assert past.after((goal,)) is None  # It lies well beyond the bend.
