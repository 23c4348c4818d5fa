"""Notes of agents as readers see them: strangers' texts, some in forms that are known."""

import json

import pytest

from arramon_server.sim.geometry import Pose
from arramon_server.web.page_texts import all_texts
from arramon_server.web.watch.shown_notes import MAX_READING, ShownNote, shown_note
from arramon_server.web.watch.stage import from_start

EN = all_texts()["en"]


@pytest.mark.parametrize(
    ("note", "expected"),
    [
        ("plain words", ShownNote((), "plain words")),
        ("[1, 2]", ShownNote((), "[1, 2]")),
        ("{}", ShownNote((), "{}")),
        ('{"a": 1', ShownNote((), '{"a": 1')),
        ("<b>bold</b>", ShownNote((), "<b>bold</b>")),
        ('{"goal":[1.5,-2]}', ShownNote((), goal=(1.5, -2.0))),
        ('{"goal":[true,2]}', ShownNote((("Waypoint", "[True; 2]"),))),
        ('{"goal":[1,1e9]}', ShownNote((("Waypoint", "[1; 1000000000.0]"),))),
        ('{"goal":"<i>"}', ShownNote((("Waypoint", "<i>"),))),
        ('{"step":3,"search":true}', ShownNote((("Carries out step", "3"), ("Searches", "✓")), step=3)),
        ('{"step":-3}', ShownNote((("Carries out step", "-3"),))),
        (
            '{"thought":"go","plan":["forward","left"],"tokens":[900,12],"usd":0.00123,"calls":1}',
            ShownNote((
                ("Thought", "go"), ("Plan", "forward, left"), ("Calls of the model", "1"),
                ("Tokens, read and written", "900 + 12"), ("Cost", "$0.00123"),
            )),
        ),
        ('{"mine":{"kind":"mug","near":["a","b"]}}', ShownNote((("mine", "mug, near [a; b]"),))),
        (
            '{"read":{"steps":[{"do":"walk","past":{"kind":"bench","colour":"red"}}],"target":{"kind":"mug"}},"step":1}',
            ShownNote((("Carries out step", "1"),), step=1, reading=("walk, past (bench, red)", "Object: mug")),
        ),
        ('{"read":{"steps":7}}', ShownNote((), reading=("steps 7",))),
        ('{"read":"all of it"}', ShownNote(())),
    ],
)  # fmt: skip
def test_notes(note: str, expected: ShownNote) -> None:
    assert shown_note(EN, note) == expected


def test_very_long_readings_are_cut() -> None:
    note = json.dumps({"read": {"steps": [{"do": "walk"}] * 500}})
    assert len(shown_note(EN, note).reading) == MAX_READING


@pytest.mark.parametrize(("heading", "place"), [(0.0, (11.0, 22.0)), (90.0, (12.0, 19.0)), (180.0, (9.0, 18.0))])
def test_waypoints_are_places_of_the_world(heading: float, place: tuple[float, float]) -> None:
    start = Pose(10.0, 20.0, heading)
    found = from_start(start, (1.0, 2.0))
    assert found == pytest.approx(place)
    assert start.local(*found) == pytest.approx((1.0, 2.0))
