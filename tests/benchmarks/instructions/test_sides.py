"""Detection of wrong sides and crossings beside targets, independent of planner and gate."""

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.instructions.references import check
from benchmarks.instructions.sides import crossing_faults, side_faults, stated_sides, things_in_street
from benchmarks.instructions.turn_paths import turn_path

NORTH, EAST, WEST = (0.0, 1.0), (1.0, 0.0), (-1.0, 0.0)


def path(*legs: tuple[tuple[float, float], int]) -> list[tuple[float, float]]:
    places = [(0.0, -15.0)]
    for (x, z), steps in legs:
        for _ in range(steps):
            places.append((places[-1][0] + x, places[-1][1] + z))
    return places


PATH = path((NORTH, 15), (EAST, 8), (NORTH, 12))
"""North to a corner at (0, 0), right, and left at (8, 0)."""

MUG = {"type": {"pattern": "striped", "colour": "red", "kind": "mug"}, "position": [8.0, 0.1, 13.5]}


def building(facade: str, x: float, z: float, half_width: float, half_length: float) -> dict[str, Any]:
    return {"x": x, "z": z, "half_width": half_width, "half_length": half_length, "heading": 0.0, "facade": facade}


def prop(kind: str, x: float, z: float, colour: str = "", heading: float = 0.0) -> dict[str, Any]:
    return {"kind": kind, "x": x, "z": z, "heading": heading, "colour": colour, "shape": ""}


AHEAD = building("red", 14.0, 1.0, 3.0, 5.0)
"""Straight ahead of who comes from the corner, and on the right after the second turn."""

SOUTH = building("red", 4.5, -5.5, 2.5, 3.5)
"""On the right between the turns."""

MARCH = {
    "en": "Turn right at the corner and march past the red building on your right. Turn left. Get the striped red mug.",
    "hi": "नुक्कड़ पर दाएँ मुड़ें और लाल इमारत को अपनी दाईं ओर रखते हुए आगे बढ़ें। बाएँ मुड़ें। धारीदार लाल मग उठाएँ।",
}


def faults(text: str, code: str, *things: dict[str, Any], way: list[tuple[float, float]] = PATH) -> list[str]:
    section = {
        "props": [thing for thing in things if "kind" in thing],
        "buildings": [thing for thing in things if "facade" in thing],
    }
    turn = {"street": [MUG], "path": way, "actions": []}
    return side_faults(text, code, turn_path(turn, {"heading": 0.0}, []), things_in_street(turn, section))


@pytest.mark.parametrize("code", ["en", "hi"])
@pytest.mark.parametrize(
    ("things", "is_so"), [((AHEAD,), False), ((SOUTH,), True), ((AHEAD, SOUTH), True), ((), False)]
)
def test_the_side_of_a_building_is_that_before_the_next_turn(code: str, things: tuple[Any, ...], is_so: bool) -> None:
    assert (faults(MARCH[code], code, *things) == []) == is_so


TEXTS = [
    ("en", "Turn right at the corner. Go past the tree on your right. Turn left."),
    ("en", "Turn right at the corner. With the tree on your right, go past it. Turn left."),
    ("en", "Turn right at the corner, keep the tree to your right and go past it. Turn left."),
    ("en", "Turn right at the corner. Walk past the tree, keeping it on your right. Turn left."),
    ("en", "Make a right at the corner. Walk until the tree is on your right. Steer to the left."),
    ("en", "At the corner, turn right. Go until you have the tree on your right. Make a left."),
    ("hi", "नुक्कड़ पर दाएँ मुड़ें। पेड़ को दाईं ओर रखते हुए आगे बढ़ें। बाएँ मुड़ें।"),
    ("hi", "नुक्कड़ पर दाएँ मुड़ें। दाईं ओर वाले पेड़ से आगे बढ़ें। बाईं ओर मुड़ें।"),
    ("hi", "नुक्कड़ पर दाईं तरफ़ मुड़ें। दाईं तरफ़ के पेड़ के पास से गुज़रें। बाएँ मुड़ें।"),
    ("hi", "नुक्कड़ पर दाएँ मुड़ें। तब तक चलें जब तक पेड़ आपकी दाईं ओर न आ जाए। बायाँ मोड़ लें।"),
    ("hi", "नुक्कड़ पर दाएँ मुड़ें। पेड़ के आपकी दाईं ओर आने तक चलें। बाएँ मुड़ें।"),
    ("hi", "नुक्कड़ पर दाएँ मुड़ें। दाईं ओर पेड़ आएगा, उसके पास से निकलें। बाएँ मुड़ें।"),
    ("hi", "नुक्कड़ पर राइट मुड़ें। पेड़ को अपनी राइट साइड रखते हुए चलते रहें। लेफ़्ट में मुड़ें।"),
    ("hi", "वहाँ से दाएँ मुड़ें। तब तक चलें जब तक पेड़ आपकी दाईं ओर न आ जाए। उसके आगे से बाईं ओर मुड़ें।"),
]


@pytest.mark.parametrize(("code", "text"), TEXTS)
def test_a_side_is_found_in_all_ways_to_tell_it(code: str, text: str) -> None:
    (told,) = stated_sides(text, code)
    assert (told.mention.kind, told.side, told.before, told.after) == ("tree", "right", ("right",), ("left",))
    for place, is_so in (((4.0, -2.0), True), ((4.0, 2.0), False), ((11.0, 1.0), False), ((10.0, 6.0), False)):
        assert (faults(text, code, prop("tree", *place)) == []) == is_so, place


NO_SIDES = [
    ("en", "Turn right right before the tree. Take the second street on your left. Go to the bench."),
    ("en", "Turn slightly left at the tree. The mug is to the left of the bench. Steer to the right."),
    ("hi", "पेड़ से पहले दाईं ओर मुड़ें। बाईं ओर की दूसरी सड़क पर मुड़ें। बेंच के बाईं ओर रखा मग उठाएँ।"),
    ("hi", "पेड़ के पास थोड़ा बाएँ मुड़ें। अपनी दाईं ओर मुड़ें।"),
    ("hi", "पेड़ के पास बाईं ओर मुड़ें। फिर बेंच आएगी, उससे आगे निकलें।"),
]


@pytest.mark.parametrize(("code", "text"), NO_SIDES)
def test_sides_of_turns_and_of_the_target_are_none_of_things_on_the_way(code: str, text: str) -> None:
    assert stated_sides(text, code) == []


def test_turns_are_found_among_the_bends() -> None:
    """Who turns around first, steps aside around a barrier, and turns right, passes a tree before that turn."""
    way = [(0.0, -z) for z in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)] + [(1.5, -6.0), (1.5, -7.0), (0.0, -8.0)]
    way += [(0.0, -z) for z in (9.0, 10.0, 11.0, 12.0)] + [(-x, -12.0) for x in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)]
    text = "Turn around. Pass the tree on your right. Turn right. Pick up the striped red mug."
    assert faults(text, "en", prop("tree", -2.0, -4.0), way=way) == []
    assert faults(text, "en", prop("tree", -4.0, -14.0), way=way) != []


def test_all_stated_turns_are_matched_even_where_two_of_them_step_aside() -> None:
    """The way has as many bends as the text has turns, besides the last one, which is made at the target."""
    way = path((NORTH, 10), (EAST, 10), (NORTH, 10), (EAST, 4), (NORTH, 10), (EAST, 2))
    text = "At the corner turn right. Turn left. Turn right. Turn left and walk until the tree is on your right."
    assert faults(text, "en", prop("tree", 16.0, 7.0), way=way) == []
    assert faults(text, "en", prop("tree", 12.0, 7.0), way=way) != []


ZEBRA = prop("zebra_crossing", 8.0, 11.0)

BY = [
    ("en", "Pick up the striped red mug next to the zebra crossing.", 1),
    ("en", "Near the crosswalk you'll find a striped red mug. Take it.", 1),
    ("en", "The striped red mug is to the left of the pedestrian crossing; pick it up.", 1),
    ("en", "Go past the zebra crossing. Pick up the striped red mug next to the bench.", 0),
    ("hi", "ज़ेबरा क्रॉसिंग के पास रखा धारीदार लाल मग उठाएँ।", 1),
    ("hi", "ज़ेबरा क्रॉसिंग की बगल में रखा धारीदार लाल मग उठाएँ।", 1),
    ("hi", "ज़ेबरा क्रॉसिंग के बाईं ओर रखा धारीदार लाल मग उठाएँ।", 1),
    ("hi", "ज़ेबरा क्रॉसिंग के पास से गुज़रें। बेंच के पास रखा धारीदार लाल मग उठाएँ।", 0),
]


@pytest.mark.parametrize(("code", "text", "count"), BY)
@pytest.mark.parametrize(
    ("x", "z", "is_on"),
    [(8.0, 11.0, True), (10.0, 11.5, True), (10.5, 11.0, False), (8.0, 12.0, False), (8.0, 9.5, False)],
)
def test_what_lies_on_a_crossing_does_not_lie_by_it(
    code: str, text: str, count: int, x: float, z: float, is_on: bool
) -> None:
    """The crossing reaches 2.275 units to each side of the street and 0.7 along it."""
    grounds = things_in_street({"street": [MUG]}, {"props": [ZEBRA, prop("bench", 5.0, 11.0)], "buildings": []})
    found = crossing_faults(text, code, (x, z), grounds)
    assert found == (count, ["the target lies on the zebra_crossing, not by it"] if is_on and count else [])


def test_the_command_counts_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    split = tmp_path / "splits" / "small"
    (split / "sections").mkdir(parents=True)
    (split / "sections" / "1.json").write_text(json.dumps({"props": [ZEBRA], "buildings": [AHEAD]}))
    texts = {
        code: [{"navigation": text}, {"navigation": BY[number][1]}]
        for (code, text), number in zip(MARCH.items(), (0, 4), strict=True)
    }
    on = {**MUG, "position": [8.0, 0.1, 11.0]}
    episode = {
        "episode_id": "5000",
        "section": "1",
        "start": {"x": 0.0, "z": -15.0, "heading": 0.0},
        "turns": [{"street": [MUG], "path": PATH, "actions": [0]}, {"street": [on], "path": PATH, "actions": [0]}],
        "instructions": texts,
    }
    (split / "episodes.jsonl").write_text(f"{{}}\n{json.dumps(episode)}\n")
    check(tmp_path, [], 9)
    out = capsys.readouterr().out
    for code in ("en", "hi"):
        line = next(line for line in out.splitlines() if line.startswith(f"small section 1 {code}"))
        assert line.endswith("0 texts false; 1 sides on the way, 1 texts false; 1 by a crossing, 1 on it"), line
    assert out.count("building is not passed on the right") == 2
    assert out.count("the target lies on the zebra_crossing, not by it") == 2
