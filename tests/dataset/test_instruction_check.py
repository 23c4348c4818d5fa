"""The command `arramon-server check-instruction`: output and exit status."""

import io
from collections.abc import Callable

import pytest

from arramon_server.cli import main

MUG = "Turn left and take the dotted red mug."

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    def run(*arguments: str, given: str = "") -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO(given))
        status = main(["check-instruction", *arguments])
        return status, *capsys.readouterr()

    return run


def test_good_text_passes_every_check(run: Run) -> None:
    assert run("--phase", "navigation", "--target", "dotted red mug", MUG) == (0, f"{MUG}\n  passes every check\n", "")


def test_suspicious_text_exits_with_status_0(run: Run) -> None:
    status, said, _ = run("--phase", "navigation", "--target", "blue mug", MUG)
    assert (status, said.splitlines()[1:]) == (0, ["  suspicious: no_target: does not name the blue mug"])


def test_texts_are_read_from_standard_input(run: Run) -> None:
    text = "बाएँ मुड़ें और लाल लाल मग उठा लें।"
    status, said, _ = run("--phase", "navigation", "--lang", "hi", given=f"{text}\n\nबाएँ मुड़ें और लाल मग उठा लें।\n")
    assert status == 1
    assert said.splitlines() == [
        text,
        "  blocked: repeated_word: 'लाल' occurs twice in a row",
        "बाएँ मुड़ें और लाल मग उठा लें।",
        "  passes every check",
    ]


def test_missing_initial_turn_is_reported(run: Run) -> None:
    status, said, _ = run("--phase", "navigation", "--first-turn", "60", "Walk ahead and take the dotted red mug.")
    assert status == 1
    assert "the path begins with a turn of 60 degrees; expected 'turn...'" in said


def test_unknown_languages_and_targets_are_refused(run: Run) -> None:
    assert run("--phase", "navigation", "--lang", "xx", MUG)[0::2] == (
        1,
        "arramon-server: no language 'xx'; there are en, hi, te\n",
    )
    status, _, said = run("--phase", "navigation", "--target", "wall", MUG)
    assert status == 1
    assert said.startswith("arramon-server: target 'wall' names 0 objects; expected one")
