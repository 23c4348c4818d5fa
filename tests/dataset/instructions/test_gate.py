"""The gate: texts and meanings that are not so in a small town are found out, in both languages."""

from dataclasses import replace

import pytest

from lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk, Where
from server.dataset.instructions.gate import faults_of_text
from server.dataset.instructions.gate_navigation import faults_of_navigation
from server.dataset.instructions.gate_world import GateWorld
from server.dataset.instructions.sight import Landmark
from server.dataset.plans.graph import Arm, Junction, Road, StreetGraph
from server.sim.labels import Label
from tests.dataset.instructions.town import PATH, START


def mark(identity: str, x: float, z: float, colour: str = "", look: str = "") -> Landmark:
    return Landmark(Label(identity.split("/")[0], colour, look), x, z, (0,), 0, identity)


MARKS = (
    mark("barrier/0", 2.0, -10.0, "white"),
    mark("barrier/1", 8.0, 2.0, "white"),
    mark("barrel/0", -2.0, -5.0, "red"),
    mark("bench/0", 2.2, -2.5),
    mark("bench/1", 2.2, -4.0),
    mark("cone/0", 6.0, -2.0, "orange"),
    replace(mark("collectible/0", 13.5, 0.0), label=Label("mug", "red", "striped")),
    replace(mark("collectible/1", 0.0, 12.0), label=Label("mug", "red", "dotted")),
    replace(mark("collectible/2", 15.0, 0.5), label=Label("ball", "blue", "striped")),
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


def told(*steps: Step, target: Thing = MUG) -> Navigation:
    return Navigation(steps, target)


TRUE = [
    told(Walk("past", (NEAR,), "right"), Rotate("right", "at", CROSSING)),
    told(Walk("past", (NEAR,)), Rotate("right", "after", BENCHES), Walk("past", (replace(FAR, which="another"),))),
    told(Walk("past", (BARREL,), "left"), Walk("to", (CROSSING,)), Rotate("right"), Walk("past", (CONE,))),
    told(Rotate("right", "at", Thing("street", which="first", identity="street/1")), Walk("beside", (CONE,), "right")),
    told(
        Walk("along", (Thing("street", identity="street/0"),)), Walk("past", (BENCHES,)), target=replace(MUG, where=())
    ),
    told(Walk("past", (replace(NEAR, which="first"),)), Walk("towards", (CROSSING,))),
]


@pytest.mark.parametrize("meaning", TRUE)
def test_what_is_so_passes(meaning: Navigation) -> None:
    assert faults_of_navigation(meaning, WORLD) == ()


FALSE = [
    (told(Walk("past", (NEAR,), "left")), "barrier/0 is not on the left"),
    (told(Rotate("left", "at", CROSSING)), "the path does not turn left at junction/0"),
    (told(Rotate("right", "at", BARREL)), "the path does not turn right at barrel/0"),
    (told(Walk("past", (replace(NEAR, colour="red"),))), "barrier/0 is a barrier/white, not red"),
    (told(Walk("past", (replace(BARREL, kind="bench"),))), "barrel/0 is a barrel/red, not"),
    (told(Walk("past", (NEAR,)), Walk("past", (FAR,))), "the white barrier barrier/1 is also called"),
    (told(Walk("past", (replace(NEAR, which="next"),))), "but none was named before"),
    (told(Walk("past", (Thing("bench", number="two", identity="bench/0"),))), "bench/0 is 1, not two"),
    (told(Walk("past", (replace(NEAR, which="second"),))), "barrier/0 is number 1 of its kind, not the second"),
    (told(Rotate("right", "at", replace(CROSSING, kind="t_junction"))), "junction/0 is a crossing, not a t_junction"),
    (told(Rotate("right", "at", Thing("alley", identity="street/1"))), "street/1 is no alley"),
    (told(Rotate("right", "at", Thing("street", identity="street/0"))), "does not turn right at street/0"),
    (
        told(Rotate("right", "at", Thing("street", which="second", identity="street/1"))),
        "street/1 is number 1 on the right, not the second",
    ),
    (told(Rotate("left")), "the path does not turn left after its place 0"),
    (told(Walk("past", (Thing("tree", identity="tree/0"),))), "tree 'tree/0' does not exist"),
    (told(Walk("past", (CONE,)), Walk("past", (BARREL,))), "the path does not come past barrel/0"),
    (told(Walk("between", (NEAR, CONE))), "the path does not"),
    (told(target=replace(MUG, where=(Where("behind", (BALL,)),))), "collectible/0 is not behind collectible/2"),
    (told(target=replace(MUG, where=(Where("near", (CONE,)),))), "collectible/0 is not near cone/0"),
    (told(target=replace(MUG, look="dotted")), "collectible/0 is a mug/red/striped, not red dotted mug"),
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
        (replace(MUG, where=()), (replace(OTHER_MUG, label=Label("mug", "blue", "striped")),), True),
    ],
)
def test_the_target_is_told_apart_from_what_looks_like_it(
    target: Thing, more: tuple[Landmark, ...], is_clear: bool
) -> None:
    world = replace(WORLD, marks=(*MARKS, *more))
    faults = faults_of_navigation(told(target=target), world)
    assert faults == () if is_clear else "collectible/0 may be taken for collectible/9" in faults


PLAIN = Thing("mug", "red", "striped", identity="m")
TWO = told(Walk("past", (NEAR,)), Walk("to", (replace(FAR, which="another"),)), target=PLAIN)
ONE = told(Walk("past", (NEAR,)), Walk("to", (NEAR,)), target=PLAIN)
STREET = told(Rotate("left", "at", Thing("street", which="second", identity="s")), target=PLAIN)

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
    face = told(Face(NEAR), Walk("past", (replace(NEAR, identity="barrier/1"),)), target=PLAIN)
    text = "Face the white barrier. Walk past that barrier. Pick up the striped red mug."
    assert faults_of_text(text, "en", face) == ("takes one thing for another: the white barrier barrier/1",)
