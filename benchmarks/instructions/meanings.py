"""Meanings of paraphrases that readers wrote down from the texts alone, with which readings are compared."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arramon_dataset.paraphrases.collection import Paraphrase, paraphrases

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True, slots=True)
class WrittenMeaning:
    """A meaning of a text of the development half that was written down later, from the text alone.

    Attributes:
        text: what was read.
        batch: from 1; its texts were drawn at random, and their meanings written before the reader read them.
        doubtful: phases of whose text two careful readers would say different things.
        meaning: as `Paraphrase.meaning`, but without "room" where the navigation alone was written down.
    """

    text: Paraphrase
    batch: int
    doubtful: tuple[str, ...]
    meaning: Mapping[str, Any]


def second_meanings() -> dict[tuple[str, int, str], Mapping[str, Any]]:
    """Return the meanings that another reader wrote down for some texts, by the texts' keys."""
    lines = (DATA / "second_meanings.jsonl").read_text(encoding="utf-8").splitlines()
    read = map(json.loads, lines)
    return {(each["episode"], each["turn"], each["language"]): each["meaning"] for each in read}


def development_meanings(language: str) -> tuple[WrittenMeaning, ...]:
    """Return the meanings of further texts of the development half in one language, by batch."""
    texts = {text.key: text for text in paraphrases()}
    path = DATA / f"development_meanings_{language}.jsonl"
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    read = map(json.loads, lines)
    return tuple(
        WrittenMeaning(
            texts[each["episode"], each["turn"], language], each["batch"], (*each["doubtful"],), each["meaning"]
        )
        for each in read
    )
