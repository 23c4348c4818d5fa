"""Classification of a turn by the agent's path: where it left the ground truth, and how the turn ended."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_server.episodes.episode import Episode  # noqa: E402
from arramon_server.sim.geometry import Point  # noqa: E402
from arramon_server.sim.rules import Collectible  # noqa: E402
from benchmarks.agents import trajectories as script  # noqa: E402
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
    judged = script.classify(long_episode(), turn, script.PlayedPath(poses, took))
    assert judged.cause == ("" if cause < 0 else list(script.CAUSES.values())[cause])
    assert judged.end == ("" if end < 0 else script.ENDS[end])
    assert judged.reached == pytest.approx(reached)
    assert 0.0 <= judged.ndtw <= 1.0


def test_pictures_and_table(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, "val_seen", 1)
    failed = script.classify(split.episodes["0"], 1, script.PlayedPath([(0.0, 0.0, 0.0), (-4.0, 0.0, 270.0)]))
    found = script.classify(split.episodes["0"], 1, script.PlayedPath([(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)], took=True))
    image = script.draw(failed, split.sections["1"], "en")
    assert image.width > 100
    assert image.height > 100
    text = script.table([failed, found], "en")
    assert text.startswith("1 of 2 turns did not end with the target.")
    assert "| 0, 1 | " in text
    assert "Go on to the striped red mug." in text


def test_the_sheet_has_the_worst_first_and_leaves_out_what_is_sorted(tmp_path: Path) -> None:
    first, second = long_episode(), replace(long_episode(), episode_id="8")
    paths = [
        (first, 1, script.PlayedPath(ahead(*range(15)))),
        (second, 1, script.PlayedPath([*ahead(0.0), (-8.0, 10.0, 0.0)], took=True)),
        (first, 2, script.PlayedPath([(9.0, 9.0, 0.0)])),
    ]
    text = script.sheet([script.classify(*each) for each in paths], "en", 20)
    assert text.startswith("# The 2 worst of 3 failures\n\nLeft out: 1 (turn 2 began elsewhere")
    assert text.index("## 1. Episode 8, turn 1") < text.index("## 2. Episode 7, turn 1")
    assert "Took: striped red mug." in text
    assert "Took: nothing." in text
    assert "![The way over the map](8-1.png)" in text
    assert script.sheet([script.classify(*each) for each in paths], "en", 1).count("Sort:") == 1


def test_the_command_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second time nothing is played; another agent needs another folder."""
    tiny.write(tmp_path, "val_seen", 2)
    output = tmp_path / "out"

    def run(agent: str) -> None:
        options = ["--data", str(tmp_path), "--split", "val_seen", "--agent", agent, "--output", str(output)]
        monkeypatch.setattr(sys, "argv", ["trajectories", *options])
        script.main()

    run("agents.random_walk")
    pages = [(output / name).read_text() for name in ("failures.md", "worst.md")]
    assert {path.name for path in output.glob("*.png")} >= {"0-1.png", "1-1.png"}
    monkeypatch.setattr(script, "play", None)
    run("agents.random_walk")
    assert [(output / name).read_text() for name in ("failures.md", "worst.md")] == pages
    with pytest.raises(SystemExit, match="name another --output"):
        run("agents.stop")
