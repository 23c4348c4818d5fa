"""How well generated texts can be told from people's: masks, accuracy and control on small sets with known answers."""

from pathlib import Path
from random import Random

import pytest

from benchmarks.instructions.distinguish import control, distinguish, main
from benchmarks.instructions.masking import masked_words

WALKS = ("go past the {}", "walk to the {}", "turn left at the {}", "turn right at the {}")
THINGS = ("red cone", "phone booth", "wooden bench", "fire hydrant")


@pytest.mark.parametrize(
    ("text", "language", "is_coarse", "expected"),
    [
        ("Go past the red cone.", "en", False, "< go past the COLOUR THING . >"),
        ("Go past the red cone, then stop", "en", True, "< go past the THING then stop >"),
        (
            "Take the dotted brown hourglass at the stop sign",
            "en",
            False,
            "< take the PATTERN COLOUR OBJECT at the THING >",
        ),
        ("लाल बेंच तक चलें।", "hi", False, "< COLOUR THING तक चलें । >"),
        ("लाल बेंच तक चलें।", "hi", True, "< THING तक चलें >"),
    ],
)
def test_names_of_things_are_masked(text: str, language: str, is_coarse: bool, expected: str) -> None:
    assert masked_words(text, language, is_coarse=is_coarse) == expected


def _texts(seed: int, count: int, end: str = "") -> list[list[str]]:
    random = Random(seed)
    return [[random.choice(WALKS).format(random.choice(THINGS)) + end for _ in range(2)] for _ in range(count)]


def test_texts_with_a_habit_of_their_own_are_told_apart() -> None:
    found = distinguish(_texts(1, 40), _texts(2, 60, " forthwith"), "en")
    assert (found.accuracy, found.texts) == (1.0, 80)
    assert found.second[0] == ("forthwith", 0.0, 1.0) or "forthwith" in found.second[0][0]


def test_texts_of_one_source_are_not() -> None:
    assert control(_texts(3, 80), "en", 40).accuracy < 0.65


def test_only_names_differ() -> None:
    ours = [[text.replace("cone", "kiosk").replace("bench", "planter") for text in each] for each in _texts(5, 40)]
    assert distinguish(_texts(4, 40), ours, "en").accuracy < 0.65


def test_too_few_episodes_are_refused() -> None:
    with pytest.raises(ValueError, match="9 episodes; expected at least 10"):
        distinguish(_texts(1, 9), _texts(2, 40), "en")


def test_the_release_must_be_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ARRAMON_RELEASE", str(tmp_path))
    assert main([str(tmp_path)]) == 1
    assert "val_seen.json" in capsys.readouterr().err
