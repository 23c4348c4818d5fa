"""Alphabet and lengths of instructions."""

from pathlib import Path

from arramon_server.episodes.instruction_texts import TextSummary, instructions_in
from tests import tiny

ENGLISH = ["Go on to the striped red mug.", "Put it two steps ahead."]
HINDI = ["धारीदार लाल मग तक चलें।", "उसे दो क़दम आगे रखें।"]


def test_texts() -> None:
    assert TextSummary.of(["ab", "é"]) == TextSummary("abé", 2, 2)
    assert TextSummary.of(["ल"]) == TextSummary("ल", 1, 3)
    assert TextSummary.of([]) == TextSummary("", 0, 0)


def test_a_split_tells_those_of_each_language(tmp_path: Path) -> None:
    split = tiny.write(tmp_path)
    assert split.texts == {"en": TextSummary.of(ENGLISH), "hi": TextSummary.of(HINDI)}
    assert instructions_in([split.episodes["0"]], "hi") == []
    assert instructions_in([split.episodes["1"]], "hi") == HINDI * 2
