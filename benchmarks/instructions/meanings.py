"""Meanings of paraphrases written down by annotators from the text alone, as references for parsed meanings."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arramon_dataset.paraphrases.collection import Paraphrase, paraphrases

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True, slots=True)
class WrittenMeaning:
    """A later annotation of a text of the development half, from the text alone.

    Attributes:
        text: the annotated paraphrase.
        batch: number of a random batch, from 1; annotated before the reader was tried on it.
        doubtful: phases whose text two careful readers would understand differently.
        meaning: like `Paraphrase.meaning`, but without "room" if only the navigation was annotated.
    """

    text: Paraphrase
    batch: int
    doubtful: tuple[str, ...]
    meaning: Mapping[str, Any]


def second_meanings() -> dict[tuple[str, int, str], Mapping[str, Any]]:
    """Return a second annotator's meanings of some texts, by the texts' keys."""
    lines = (DATA / "second_meanings.jsonl").read_text(encoding="utf-8").splitlines()
    read = map(json.loads, lines)
    return {(each["episode"], each["turn"], each["language"]): each["meaning"] for each in read}


def development_meanings(language: str) -> tuple[WrittenMeaning, ...]:
    """Return the later annotations of the development half in one language, by batch."""
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
