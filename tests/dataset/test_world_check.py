"""The option `--episode` of `arramon-server check-instruction`: furniture that a text names and the section lacks."""

from collections.abc import Callable
from pathlib import Path

import pytest

from arramon_server.cli import main
from tests.dataset import recovered_split

Run = Callable[..., tuple[int, list[str], str]]

TRUE = "Walk past the red barrier on your right and pick up the striped red mug next to the cone."
WRONG = "Walk past the red barrier on your left and pick up the striped red mug next to the phone booth."


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Run:
    recovered_split.write(tmp_path, TRUE, WRONG)

    def run(*arguments: str) -> tuple[int, list[str], str]:
        status = main(["check-instruction", "--phase", "navigation", "--data", str(tmp_path), *arguments])
        said = capsys.readouterr()
        return status, said.out.splitlines(), said.err

    return run


def test_a_text_whose_landmarks_are_all_there_passes(run: Run) -> None:
    status, said, _ = run("--episode", "0", "--turn", "1")
    assert (status, said) == (0, [f"turn 1: {TRUE}", "  passes every check"])


def test_landmarks_that_are_not_there_are_named(run: Run) -> None:
    status, said, _ = run("--episode", "0", "--turn", "1", WRONG)
    assert status == 0
    assert [line.partition(":  ")[0].partition(", but")[0] for line in said] == [
        f"turn 1: {WRONG}",
        "  suspicious: not_there: names a red barrier on the left",
        "  suspicious: not_there: names a phone booth",
    ]
    assert "none stands within 4 units of beside the object to pick up: turn 1, after " in said[2]


def test_without_a_text_the_episodes_own_are_checked_in_both_turns(run: Run) -> None:
    _, said, _ = run("--episode", "0")
    assert [line for line in said if line.startswith("turn ")] == [f"turn 1: {TRUE}", f"turn 2: {WRONG}"]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("--episode", "7"), "there is no episode '7' in own"),
        (("--episode", "0", "--split", "x"), "there is no split 'x'; there are own"),
        (("--episode", "0", "--lang", "hi"), "episode '0' has no instructions in 'hi'; it has en"),
        (("--split", "own", TRUE), "--split and --turn select the world of an episode"),
        (("--episode", "0", "--phase", "assembly"), "expected --phase navigation"),
    ],
)
def test_wrong_arguments_are_refused(run: Run, arguments: tuple[str, ...], problem: str) -> None:
    status, _, said = run(*arguments)
    assert status == 1
    assert problem in said
