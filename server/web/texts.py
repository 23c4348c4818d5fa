"""What the pages say, in each language: words, numbers and dates, from a file a language in `texts`."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "texts"

DEFAULT = "en"
"""For a browser that asks for none of the languages that there are."""


@dataclass(frozen=True, slots=True)
class Texts:
    """One language's texts.

    Args:
        language: its code, which is also the first part of its pages' addresses.
        words: what is said, by dotted key such as `standings.empty`.
    """

    language: str
    words: Mapping[str, Any]

    def __call__(self, key: str, **values: object) -> str:
        """What is said under a key, with its `{names}` filled in.

        Raises:
            KeyError: for a key or a name that is not there.
        """
        text: str = self.words[key]
        return text.format(**values)

    def named(self, group: str, name: str) -> str:
        """The word for one of a group, such as a sensor; the name itself where the file has none."""
        return str(self.words.get(f"{group}.{name}", name))

    def score(self, value: float) -> str:
        """A score as in the paper's tables, with three decimals."""
        return self._localised(f"{value:.3f}")

    def percent(self, share: float) -> str:
        """A share of one in whole percent; 100% is all and 0% is none."""
        bounded = min(max(round(100 * share), 1), 99) if 0 < share < 1 else round(100 * share)
        return self("format.percent", number=bounded)

    def whole(self, number: int) -> str:
        """A whole number, its digits in the language's groups."""
        first, further = self.words["format.groups"]
        digits, parts = str(number), []
        size = first
        while len(digits) > size:
            digits, part = digits[:-size], digits[-size:]
            parts.append(part)
            size = further
        return self("format.group_mark").join([digits, *reversed(parts)])

    def decimal(self, number: float) -> str:
        """A number with as many decimals as it needs, at most two."""
        if number.is_integer():
            return self.whole(int(number))
        return self._localised(f"{number:.2f}".rstrip("0").rstrip("."))

    def date(self, time: datetime) -> str:
        """A day."""
        month = self.words["format.months"][time.month - 1]
        return self("format.date", day=time.day, month=month, year=time.year)

    def moment(self, time: datetime) -> str:
        """A day and the time of day, in UTC."""
        return self("format.moment", date=self.date(time), time=f"{time:%H:%M}")

    def _localised(self, number: str) -> str:
        return number.replace(".", self("format.decimal_mark"))


@cache
def all_texts() -> dict[str, Texts]:
    """The texts of every language that has a file, by code; the default language first."""
    codes = sorted((path.stem for path in FOLDER.glob("*.toml")), key=lambda code: (code != DEFAULT, code))
    return {code: read(FOLDER / f"{code}.toml") for code in codes}


def read(path: Path) -> Texts:
    """The texts of one file; its name is the language's code."""
    return Texts(path.stem, dict(_flat(tomllib.loads(path.read_text(encoding="utf-8")))))


def preferred(accepted: str) -> str:
    """The language for a browser.

    Args:
        accepted: its `Accept-Language`, such as `hi-IN, hi;q=0.9, en;q=0.8`.
    """
    wishes = []
    for place, part in enumerate(accepted.split(",")):
        tag, _, weight = part.strip().partition(";q=")
        try:
            wishes.append((-float(weight or 1), place, tag.partition("-")[0].lower()))
        except ValueError:
            continue
    return next((code for weight, _, code in sorted(wishes) if weight < 0 and code in all_texts()), DEFAULT)


def _flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for key, value in table.items():
        pairs += _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else [(f"{prefix}{key}", value)]
    return pairs
