"""Street plans: reading of plan files, and errors that name the mistake."""

from pathlib import Path

import numpy as np
import pytest

from arramon_dataset.plans import plan_ids, read_plan
from arramon_server.errors import BadFile, NotFound

CROSS = """
id = "cross"
name = "A crossing"
heading = 90.0
origin = [100, 200]

[[streets]]
name = "Long Street"
width = 6
points = [[0, -15], [0, 15]]

[[streets]]
name = "Cross Street"
width = 2.5
points = [[-10, 0], [10, 5]]
"""


def write(folder: Path, text: str) -> Path:
    (folder / "cross.toml").write_text(text)
    return folder


def test_plan_coordinates_are_rotated_and_shifted_to_the_world(tmp_path: Path) -> None:
    plan = read_plan("cross", write(tmp_path, CROSS))
    assert (plan.name, plan.heading, plan.squares) == ("A crossing", 90.0, ())
    assert [street.width for street in plan.streets] == [6.0, 2.5]
    np.testing.assert_allclose(plan.lines()[0], [(85, 200), (115, 200)], atol=1e-9)  # along +x: heading 90
    np.testing.assert_allclose(plan.lines()[1], [(100, 210), (105, 190)], atol=1e-9)  # to the right of it is -z


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("width = 2.5", "width = 1.5", r"cross\.toml: streets\[1\]\.width: .*greater than or equal to 2; got 1\.5"),
        ("width = 2.5", 'width = "wide"', r"streets\[1\]\.width: .*got \"wide\""),
        ("width = 2.5", "breadth = 2.5", r"streets\[1\]\.width: "),
        ("[[-10, 0], [10, 5]]", "[[-10, 0]]", r"streets\[1\]\.points: .*at least 2"),
        ("[[-10, 0], [10, 5]]", "[[-10, 0], [-10, 0.2]]", r"streets\[1\]\.points: .* are the same point"),
        ("heading = 90.0", "heading = 200", r"heading: .*less than 180; got 200"),
        ("heading = 90.0", "heading = nan", "not finite"),
        ("heading = 90.0", "heading = 90.0\ntown = 1", r"town: "),
        ('id = "cross"', 'id = "square"', r"id: is 'square'; expected 'cross', the file's name"),
        ("[[streets]]", "[[streets", "is not TOML"),
    ],
)
def test_invalid_plan_fields_are_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(BadFile, match=words):
        read_plan("cross", write(tmp_path, CROSS.replace(old, new)))


def test_unknown_section_error_lists_the_known_ones() -> None:
    with pytest.raises(NotFound, match="no plan of section '99'; there are 1, 2, 3, 4, 5, 6, 7"):
        read_plan("99")
    assert plan_ids() == tuple("1234567")
