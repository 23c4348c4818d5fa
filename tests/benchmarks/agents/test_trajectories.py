"""What can be told of a turn from the agent's way: where it left the path, and how the turn ended."""

from dataclasses import replace
from pathlib import Path

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import trajectories as script  # noqa: E402
from server.episodes.episode import Episode  # noqa: E402
from server.sim.geometry import Point  # noqa: E402
from server.sim.rules import Collectible  # noqa: E402
from tests import tiny  # noqa: E402


def long_episode() -> Episode:
    """An episode whose first turn leads 20 units ahead; another mug lies at one side."""
    first, second = tiny.episode("7").turns
    mugs = tuple(Collectible(tiny.TARGETS[0], Point(x, 0.1, z)) for x, z in ((0.0, 21.5), (-8.0, 11.5)))
    first = replace(first, path=tuple((0.0, float(z)) for z in range(21)), street=(*mugs, *first.street[1:]))
    return replace(tiny.episode("7"), turns=(first, second))


def ahead(*zs: float) -> list[tuple[float, float, float]]:
    return [(0.0, z, 0.0) for z in zs]


@pytest.mark.parametrize(
    ("turn", "poses", "took", "cause", "end", "reached"),
    [  # Cause and end by their numbers in the script; -1 for none.
        (1, ahead(*range(21)), True, -1, -1, 1.0),
        (1, ahead(0.0, -5.0, -10.0), False, 1, 2, 0.1),
        (1, [*ahead(*range(11)), (-8.0, 10.0, 0.0)], True, 2, 0, 0.6),
        (1, [*ahead(*range(21)), (0.0, 20.0, 180.0)], False, 3, 2, 1.0),
        (1, [(-6.0, -8.0, 0.0)], True, 0, 1, 0.0),
        (2, [(9.0, 9.0, 0.0)], False, 0, 2, 0.0),
    ],
)
def test_a_turn_is_judged(
    turn: int,
    poses: list[tuple[float, float, float]],
    took: bool,
    cause: int,
    end: int,
    reached: float,
) -> None:
    judged = script.judge(long_episode(), turn, script.Way(poses, took))
    assert judged.cause == ("" if cause < 0 else script.CAUSES[cause])
    assert judged.end == ("" if end < 0 else script.ENDS[end])
    assert judged.reached == pytest.approx(reached)
    assert 0.0 <= judged.ndtw <= 1.0


def test_pictures_and_table(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, "val_seen", 1)
    failed = script.judge(split.episodes["0"], 1, script.Way([(0.0, 0.0, 0.0), (-4.0, 0.0, 270.0)]))
    found = script.judge(split.episodes["0"], 1, script.Way([(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)], took=True))
    image = script.draw(failed, split.sections["1"], "en")
    assert image.width > 100
    assert image.height > 100
    text = script.table([failed, found], "en")
    assert text.startswith("1 of 2 turns did not end with the target.")
    assert "| 0, 1 | " in text
    assert "Go on to the striped red mug." in text
