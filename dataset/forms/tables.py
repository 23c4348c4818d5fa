"""Tables of spellings and of English words, from the TOML files in `data`."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

DATA = Path(__file__).parent / "data"

DEVANAGARI = "\u0900-\u0963\u0971-\u097f"
"""Letters and signs of Devanagari, as a regular expression's character class."""

Weights = Mapping[str, float]
"""Spellings with their weights."""


@dataclass(frozen=True, slots=True)
class Replacement:
    """English words for Hindi ones.

    Attributes:
        hindi: matches the Hindi words, whole.
        english: wordings in Latin letters.
        loan: wordings in Devanagari.
    """

    hindi: re.Pattern[str]
    english: tuple[str, ...]
    loan: tuple[str, ...]


@cache
def spellings() -> Mapping[str, Any]:
    """Return the content of `chat_spellings.toml`."""
    return tomllib.loads((DATA / "chat_spellings.toml").read_text(encoding="utf-8"))


@cache
def replacements(kind: str) -> tuple[Replacement, ...]:
    """Return the replacements of a kind, "things" or "acts", those of more words first."""
    data = tomllib.loads((DATA / "hindi_english.toml").read_text(encoding="utf-8"))
    return tuple(
        Replacement(
            re.compile(f"(?<![{DEVANAGARI}])(?:{entry['hindi']})(?![{DEVANAGARI}])"),
            tuple(entry["english"]),
            tuple(entry["loan"]),
        )
        for entry in data[kind]
    )


def draw(weights: Weights, random: Random) -> str:
    """Return one of the spellings, drawn by weight; "none" is no letter."""
    chosen = random.choices(list(weights), list(weights.values()))[0]
    return "" if chosen == "none" else chosen
