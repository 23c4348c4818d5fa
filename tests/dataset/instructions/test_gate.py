"""The gate rejects false texts and meanings in a small town, in both languages."""

import math
from dataclasses import replace

import pytest

from arramon_dataset.instructions.gate.navigation import faults_of_navigation
from arramon_dataset.instructions.gate.texts import faults_of_text
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.plans.graph import Arm, Junction, Road, StreetGraph
from arramon_lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk, Where
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from tests.dataset.instructions.town import PATH, START


def mark(identity: str, x: float, z: float, colour: str = "", look: str = "") -> Landmark:
    return Landmark(SegmentationLabel(identity.split("/")[0], colour, look), x, z, (0,), 0, identity)


MARKS = (
    mark("barrier/0", 2.0, -10.0, "white"),
    mark("barrier/1", 8.0, 2.0, "white"),
    mark("barrel/0", -2.0, -5.0, "red"),
    mark("bench/0", 2.2, -2.5),
    mark("bench/1", 2.2, -4.0),
    mark("cone/0", 6.0, -2.0, "orange"),
    replace(mark("collectible/0", 13.5, 0.0), label=SegmentationLabel("mug", "red", "striped")),
    replace(mark("collectible/1", 0.0, 12.0), label=SegmentationLabel("mug", "red", "dotted")),
    replace(mark("collectible/2", 15.0, 0.5), label=SegmentationLabel("ball", "blue", "striped")),
    replace(mark("collectible/3", 15.0, -2.0), label=SegmentationLabel("ball", "blue", "striped")),
    mark("bin/0", -2.0, -10.0),
    mark("lamp_post/0", 2.4, -12.0),
    mark("hydrant/0", -0.5, -8.0),
    mark("kiosk/0", -7.0, -14.0),
    mark("zebra_crossing/0", 5.0, -1.5),
)

ROADS = (
    Road("street/0", "North", "street", 6.0, ((0.0, -20.0), (0.0, 20.0)), ("junction/0",)),
    Road("street/1", "East", "street", 6.0, ((-20.0, 0.0), (20.0, 0.0)), ("junction/0",)),
)
ARMS = tuple(
    Arm(heading, road, "", x, z)
    for heading, road, x, z in (
        (0.0, "street/0", 0.0, 3.0),
        (90.0, "street/1", 3.0, 0.0),
        (180.0, "street/0", 0.0, -3.0),
        (270.0, "street/1", -3.0, 0.0),
    )
)
GRAPH = StreetGraph((Junction("junction/0", 0.0, 0.0, "crossing", ARMS, 3.0),), ROADS, (), ())
WORLD = GateWorld(PATH, START, MARKS, (13.5, 0.0), GRAPH)

BALL = Thing("ball", "blue", "striped", identity="collectible/2")
MUG = Thing("mug", "red", "striped", where=(Where("in_front_of", (BALL,)),), identity="collectible/0")
NEAR, FAR = Thing("barrier", "white", identity="barrier/0"), Thing("barrier", "white", identity="barrier/1")
BARREL, CONE = Thing("barrel", "red", identity="barrel/0"), Thing("cone", identity="cone/0")
BENCHES = Thing("bench", number="two", identity="bench/0+bench/1")
CROSSING = Thing("intersection", identity="junction/0")
BIN, POST = Thing("bin", identity="bin/0"), Thing("lamp_post", identity="lamp_post/0")
KIOSK = Thing("kiosk", identity="kiosk/0")
HYDRANT, ZEBRA = Thing("hydrant", identity="hydrant/0"), Thing("zebra_crossing", identity="zebra_crossing/0")
FAR_BALL = replace(BALL, identity="collectible/3")


def wording(*steps: Step, target: Thing = MUG) -> Navigation:
    return Navigation(steps, target)


TRUE = [
    wording(Walk("past", (NEAR,), "right"), Rotate("right", "at", CROSSING)),
    wording(Walk("past", (NEAR,)), Rotate("right", "after", BENCHES), Walk("past", (replace(FAR, which="another"),))),
    wording(Walk("past", (BARREL,), "left"), Walk("to", (CROSSING,)), Rotate("right"), Walk("past", (CONE,))),
    wording(
        Rotate("right", "at", Thing("street", which="first", identity="street/1")), Walk("beside", (CONE,), "right")
    ),
    wording(
        Walk("along", (Thing("street", identity="street/0"),)),
        Rotate("right", "after", BENCHES),
        target=replace(MUG, where=()),
    ),
    wording(Walk("past", (replace(NEAR, which="first"),)), Walk("towards", (CROSSING,)), Rotate("right")),
    wording(Walk("between", (NEAR, BIN)), Rotate("right", "at", Thing("corner", identity="junction/0"))),
    wording(Rotate("right", "at", Thing("street", identity="street/1")), Walk("past", (ZEBRA,))),
]


@pytest.mark.parametrize("meaning", TRUE)
def test_what_is_so_passes(meaning: Navigation) -> None:
    assert faults_of_navigation(meaning, WORLD) == ()


FALSE = [
    (wording(Walk("past", (NEAR,), "left")), "barrier/0 is not on the left"),
    (wording(Rotate("left", "at", CROSSING)), "the path does not turn left at junction/0"),
    (wording(Rotate("right", "at", BARREL)), "the path does not turn right at barrel/0"),
    (wording(Walk("past", (replace(NEAR, colour="red"),))), "barrier/0 is a barrier/white, not red"),
    (wording(Walk("past", (replace(BARREL, kind="bench"),))), "barrel/0 is a barrel/red, not"),
    (wording(Walk("past", (NEAR,)), Walk("past", (FAR,))), "the white barrier barrier/1 is also called"),
    (wording(Walk("past", (replace(NEAR, which="next"),))), "but none was named before"),
    (wording(Walk("past", (Thing("bench", number="two", identity="bench/0"),))), "bench/0 is 1, not two"),
    (wording(Walk("past", (replace(NEAR, which="second"),))), "barrier/0 is number 1 of its kind, not the second"),
    (
        wording(Rotate("right", "at", replace(CROSSING, kind="t_junction"))),
        "junction/0 is a crossing, not a t_junction",
    ),
    (wording(Rotate("right", "at", Thing("alley", identity="street/1"))), "street/1 is no alley"),
    (wording(Rotate("right", "at", Thing("street", identity="street/0"))), "does not turn right at street/0"),
    (
        wording(Rotate("right", "at", Thing("street", which="second", identity="street/1"))),
        "street/1 is number 1 on the right, not the second",
    ),
    (wording(Rotate("left")), "the path does not turn left after its place 0"),
    (wording(Walk("past", (Thing("tree", identity="tree/0"),))), "tree 'tree/0' does not exist"),
    (wording(Walk("past", (CONE,)), Walk("past", (BARREL,))), "the path does not come past barrel/0"),
    (wording(Walk("between", (NEAR, CONE))), "the path does not"),
    (wording(target=replace(MUG, where=(Where("behind", (BALL,)),))), "collectible/0 is not behind collectible/2"),
    (wording(target=replace(MUG, where=(Where("near", (CONE,)),))), "collectible/0 is not near cone/0"),
    (wording(target=replace(MUG, look="dotted")), "collectible/0 is a mug/red/striped, not red dotted mug"),
    (wording(Walk("between", (NEAR, POST))), "the path does not lead between barrier/0 and lamp_post/0"),
    (wording(Walk("between", (BIN, Thing("bench", identity="bench/1")))), "the path does not lead between bin/0"),
    (wording(Walk("past", (BENCHES,))), "the path turns by 90 degrees at its place 15, which is not mentioned"),
    (wording(Rotate("slightly right", "at", CROSSING)), "the path does not turn slightly right at junction/0"),
    (wording(Rotate("around")), "the path does not turn around after its place 0"),
    (wording(Rotate("right", "at", CROSSING), Walk("past", (ZEBRA,), "right")), "zebra_crossing/0 is not on the right"),
    (wording(Walk("past", (HYDRANT,), "left")), "hydrant/0 is not on the left"),
    (wording(Walk("to", (CONE,))), "cone/0 is not straight ahead"),
    (wording(Walk("towards", (NEAR,), far=True)), "barrier/0 is not in the distance"),
    (wording(Face(KIOSK), Rotate("right", "at", CROSSING)), "the path does not continue towards kiosk/0"),
    (
        wording(Rotate("right", "at", CROSSING), Walk("past", (CONE,)), Walk("past", (BENCHES,))),
        "bench/0 is not ahead of the walker",
    ),
    (wording(target=replace(MUG, where=(Where("near", (FAR_BALL,)),))), "another is nearer to collectible/0"),
]


@pytest.mark.parametrize(("meaning", "fault"), FALSE)
def test_what_is_not_so_is_a_fault(meaning: Navigation, fault: str) -> None:
    assert any(fault in each for each in faults_of_navigation(meaning, WORLD)), faults_of_navigation(meaning, WORLD)


OTHER_MUG = replace(MARKS[6], x=-9.0, z=-9.0, identity="collectible/9")
BESIDE_IT = replace(MARKS[8], x=-10.0, z=-9.0, identity="collectible/8")


@pytest.mark.parametrize(
    ("target", "more", "is_clear"),
    [
        (MUG, (OTHER_MUG,), True),
        (replace(MUG, where=()), (OTHER_MUG,), False),
        (MUG, (OTHER_MUG, BESIDE_IT), False),
        (replace(MUG, where=()), (replace(OTHER_MUG, label=SegmentationLabel("mug", "blue", "striped")),), True),
    ],
)
def test_the_target_is_told_apart_from_what_looks_like_it(
    target: Thing, more: tuple[Landmark, ...], is_clear: bool
) -> None:
    world = replace(WORLD, all_landmarks=(*MARKS, *more))
    faults = faults_of_navigation(wording(Rotate("right", "at", CROSSING), target=target), world)
    assert faults == () if is_clear else "collectible/0 may be taken for collectible/9" in faults


PLAIN = Thing("mug", "red", "striped", identity="m")
TWO = wording(Walk("past", (NEAR,)), Walk("to", (replace(FAR, which="another"),)), target=PLAIN)
ONE = wording(Walk("past", (NEAR,)), Walk("to", (NEAR,)), target=PLAIN)
STREET = wording(Rotate("left", "at", Thing("street", which="second", identity="s")), target=PLAIN)

TEXTS = [
    ("en", TWO, "Walk past the white barrier. Walk to another white barrier. Pick up the striped red mug.", ""),
    ("en", TWO, "Walk past the white barrier. Walk to the same barrier. Pick up the striped red mug.", "says"),
    ("en", TWO, "Walk past the white barrier. Walk to the white barrier. Pick up the striped red mug.", "says"),
    ("en", ONE, "Walk past the white barrier. Walk to that barrier. Pick up the striped red mug.", ""),
    ("en", ONE, "Walk past the white barrier. Walk to another white barrier. Pick up the striped red mug.", "says"),
    ("en", ONE, "Walk past the white barrier. Walk to it. Pick up the striped blue mug.", "says"),
    ("en", STREET, "Take the second street on the left. Pick up the striped red mug.", ""),
    ("en", STREET, "Take the second street on the right. Pick up the striped red mug.", "says"),
    ("en", STREET, "Take the third street on the left. Pick up the striped red mug.", "says"),
    ("en", STREET, "Hm.", "nothing understood"),
    ("hi", TWO, "सफ़ेद बैरियर से आगे बढ़ें। एक और सफ़ेद बैरियर तक चलें। धारीदार लाल मग उठाएँ।", ""),
    ("hi", TWO, "सफ़ेद बैरियर से आगे बढ़ें। उसी बैरियर तक चलें। धारीदार लाल मग उठाएँ।", "says"),
    ("hi", TWO, "सफ़ेद बैरियर से आगे बढ़ें। सफ़ेद बैरियर तक चलें। धारीदार लाल मग उठाएँ।", "says"),
    ("hi", ONE, "सफ़ेद बैरियर से आगे बढ़ें। उस बैरियर तक चलें। धारीदार लाल मग उठाएँ।", ""),
    ("hi", ONE, "सफ़ेद बैरियर से आगे बढ़ें। एक और सफ़ेद बैरियर तक चलें। धारीदार लाल मग उठाएँ।", "says"),
    ("hi", STREET, "दूसरी सड़क पर बाएँ मुड़ें। धारीदार लाल मग उठाएँ।", ""),
    ("hi", STREET, "दूसरी सड़क पर दाएँ मुड़ें। धारीदार लाल मग उठाएँ।", "says"),
    ("hi", STREET, "अगली सड़क पर बाएँ मुड़ें। धारीदार लाल मग उठाएँ।", "says"),
]


@pytest.mark.parametrize(("code", "meaning", "text", "fault"), TEXTS)
def test_a_text_that_says_something_else_is_found_out(code: str, meaning: Navigation, text: str, fault: str) -> None:
    faults = faults_of_text(text, code, meaning)
    assert faults == () if not fault else any(fault in each for each in faults), faults


def test_a_thing_that_is_taken_for_another_is_found_out() -> None:
    face = wording(Face(NEAR), Walk("past", (replace(NEAR, identity="barrier/1"),)), target=PLAIN)
    text = "Face the white barrier. Walk past that barrier. Pick up the striped red mug."
    assert faults_of_text(text, "en", face) == ("takes one thing for another: the white barrier barrier/1",)


def test_a_street_at_the_start_counts() -> None:
    path = [(0.0, float(z)) for z in range(-1, 13)] + [(float(x), 12.0) for x in range(1, 7)]
    later = Junction("junction/1", 0.0, 12.0, "crossing", tuple(replace(a, z=a.z + 12.0) for a in ARMS), 3.0)
    graph = StreetGraph((*GRAPH.junctions, later), ROADS, (), ())
    world = GateWorld(path, Pose(0.0, -1.0, 0.0), (), (7.0, 12.0), graph)
    turn = wording(Rotate("right", "at", Thing("corner", identity="junction/1")), target=PLAIN)
    assert "junction/0 comes before the corner junction/1" in faults_of_navigation(turn, world)


SLIGHT, SHARP = math.radians(30.0), math.radians(60.0)
BENT = [(0.0, float(z)) for z in range(10)]


@pytest.mark.parametrize(
    ("angle", "word", "fault"),
    [
        (SLIGHT, "slightly right", False),
        (SLIGHT, "right", True),
        (SHARP, "slightly right", True),
        (SHARP, "right", False),
        (math.radians(120.0), "right", False),
        (math.radians(120.0), "around", True),
        (math.radians(150.0), "around", False),
        (math.radians(150.0), "right", True),
    ],
)
def test_a_turn_is_called_by_its_size(angle: float, word: str, fault: bool) -> None:
    on = [(math.sin(angle) * step, 9.0 + math.cos(angle) * step) for step in range(1, 8)]
    world = GateWorld((*BENT, *on), Pose(0.0, 0.0, 0.0), (mark("bin/0", 0.5, 9.5),), on[-1], GRAPH)
    faults = faults_of_navigation(wording(Rotate(word, "at", BIN), target=PLAIN), world)
    assert any(f"does not turn {word} at bin/0" in each for each in faults) == fault, faults


def test_a_corner_is_the_first_on_the_way() -> None:
    later = Junction("junction/1", 0.0, 12.0, "crossing", tuple(replace(a, z=a.z + 12.0) for a in ARMS), 3.0)
    roads = (*ROADS, Road("street/2", "High", "street", 6.0, ((-20.0, 12.0), (20.0, 12.0)), ("junction/1",)))
    graph = StreetGraph((*GRAPH.junctions, later), roads, (), ())
    path = [(0.0, float(z)) for z in range(-9, 13)] + [(float(x), 12.0) for x in range(1, 7)]
    world = GateWorld(path, Pose(0.0, -9.0, 0.0), (), (7.0, 12.0), graph)
    for thing, fault in (
        (Thing("corner", identity="junction/1"), "junction/0 comes before the corner junction/1"),
        (Thing("street", identity="street/2"), "street/2 is number 2 on the right, not the first"),
        (Thing("street", which="second", identity="street/2"), ""),
        (Thing("intersection", identity="junction/1"), "junction/0 comes before the intersection junction/1"),
    ):
        faults = faults_of_navigation(wording(Rotate("right", "at", thing), target=PLAIN), world)
        assert (fault in faults) if fault else not any("number" in each for each in faults), faults
    walk = wording(Walk("to", (Thing("intersection", identity="junction/1"),)), target=PLAIN)
    assert "junction/0 comes before the intersection junction/1" in faults_of_navigation(walk, world)
    t_junction = replace(GRAPH.junctions[0], arms=(ARMS[0], ARMS[2], ARMS[3]))
    world = replace(world, graph=replace(graph, junctions=(t_junction, later)))
    turn = wording(Rotate("right", "at", Thing("intersection", identity="junction/1")), target=PLAIN)
    assert not any("comes before" in each for each in faults_of_navigation(turn, world))


def test_one_turns_at_a_square_where_no_street_opens_before_it() -> None:
    arms = tuple(replace(arm, z=arm.z + 12.0) for arm in ARMS)
    square = Junction("junction/1", 0.0, 12.0, "square", arms, 3.0)
    graph = replace(GRAPH, junctions=(*GRAPH.junctions, square))
    path = [(0.0, float(z)) for z in range(-9, 13)] + [(float(x), 12.0) for x in range(1, 7)]
    world, named = GateWorld(path, Pose(0.0, -9.0, 0.0), (), (7.0, 12.0), graph), Thing("square", identity="junction/1")
    fault = "junction/0 comes before the square junction/1"

    assert fault in faults_of_navigation(wording(Rotate("right", "at", named), target=PLAIN), world)
    assert fault not in faults_of_navigation(wording(Walk("to", (named,)), target=PLAIN), world)
    closed = replace(GRAPH.junctions[0], arms=(ARMS[0], ARMS[2], ARMS[3]))
    world = replace(world, graph=replace(graph, junctions=(closed, square)))
    assert fault not in faults_of_navigation(wording(Rotate("right", "at", named), target=PLAIN), world)


def test_what_is_told_of_is_seen_on_the_way_to_it() -> None:
    poses = tuple(Pose(*place, 0.0) for place in PATH)
    told_of = wording(Walk("past", (NEAR,)), Rotate("right", "at", CROSSING), Walk("past", (CONE,)))
    for seen, is_seen in (((17,), True), ((12,), False), ((3, -1), False), ((), False)):
        landmarks = [replace(each, seen=seen if each.identity == "cone/0" else (2,)) for each in MARKS]
        world = replace(WORLD, all_landmarks=landmarks, poses=poses)
        fault = "cone/0 cannot be seen on the way to it"
        assert (fault not in faults_of_navigation(told_of, world)) == is_seen, seen


def way(*headings: float) -> tuple[tuple[float, float], ...]:
    """A path of one unit towards each of the headings in turn."""
    places = [(0.0, 0.0)]
    for heading in map(math.radians, headings):
        places.append((places[-1][0] + math.sin(heading), places[-1][1] + math.cos(heading)))
    return tuple(places)


AHEAD = [0.0] * 15


@pytest.mark.parametrize(
    ("headings", "told_as", "fault"),
    [
        ([*AHEAD, 15.0, 30.0, 45.0, *[60.0] * 15], None, "altogether"),
        ([*AHEAD, 15.0, *[30.0] * 15], None, ""),
        ([*AHEAD, *[30.0] * 15], "slightly right", ""),
        ([*AHEAD, *[40.0] * 4, *[0.0] * 15], "slightly right", "not turn slightly"),
        ([*AHEAD, 30.0, 30.0, 30.0, *[60.0] * 15], "slightly right", "not turn slightly"),
        ([*AHEAD, *[30.0] * 3, *[0.0] * 15], "slightly right", "not turn slightly"),
        ([*AHEAD[:12], *[-30.0] * 3, *[0.0] * 18], "slightly right", "not turn slightly"),
    ],
)
def test_small_turns_are_taken_together(headings: list[float], told_as: str | None, fault: str) -> None:
    path = way(*headings)
    world = GateWorld(path, Pose(0.0, 0.0, 0.0), (mark("bin/0", 0.5, 15.5),), path[-1], None)
    steps = () if told_as is None else (Rotate(told_as, "at", BIN),)
    faults = faults_of_navigation(wording(*steps, target=PLAIN), world)
    found = [each for each in faults if "altogether" in each or "turn slightly" in each]
    assert len(found) == bool(fault), faults
    assert all(fault in each for each in found)


def test_a_way_back_around_a_thing_at_the_start_is_no_slight_turn() -> None:
    path = way(75.0, 75.0, 165.0, 165.0, 75.0, *[105.0] * 20)
    world = GateWorld(path, Pose(0.0, 0.0, 285.0), (), path[-1], None)
    faults = faults_of_navigation(wording(Rotate("left"), Rotate("slightly left"), target=PLAIN), world)
    assert any("not turn slightly left" in fault or "turn slightly at" in fault for fault in faults)


def test_an_awning_is_told_by_its_colour_and_what_is_faced_is_walked_to() -> None:
    world = GateWorld(way(*AHEAD), Pose(0.0, 0.0, 0.0), (mark("awning/0", 1.0, 12.0, "green"),), (0.0, 15.0), None)
    bare, green = Thing("awning", identity="awning/0"), Thing("awning", "green", identity="awning/0")
    for steps, fault in (
        ((Face(bare),), "awning/0 is named without its colour"),
        ((Face(green), Rotate("right", "after", green)), "there is no walk between facing awning/0 and the turn"),
    ):
        assert fault in faults_of_navigation(wording(*steps, target=PLAIN), world)
    assert not any("colour" in each for each in faults_of_navigation(wording(Face(green), target=PLAIN), world))
