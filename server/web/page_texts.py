"""Texts of the pages, and formats of numbers and dates, read from one file per language in `texts`."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "texts"

DEFAULT_LANGUAGE = "en"
"""Language for browsers that accept none of the available ones."""


MINUS = "\N{MINUS SIGN}"

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, slots=True)
class PageTexts:
    """The texts of the pages in one language.

    Args:
        language: code of the language, which is also the first part of its pages' addresses.
        words: texts by dotted key, such as `standings.empty`.
    """

    language: str
    words: Mapping[str, Any]

    def __call__(self, key: str, **values: object) -> str:
        """Return the text of a key, with its `{names}` filled in.

        Raises:
            KeyError: if there is no such key, or a name has no value.
        """
        text: str = self.words[key]
        return text.format(**values)

    def in_groups(self, groups: Sequence[str], key: str, **values: object) -> str:
        """Return the text of a key in the first of the groups that has it, with its `{names}` filled in.

        Raises:
            KeyError: if none of the groups has it, or a name has no value.
        """
        return self(next((name for group in groups if (name := f"{group}.{key}") in self.words), key), **values)

    def named(self, group: str, name: str) -> str:
        """Return the text for a name in a group, such as "sensors"; the name itself if the group has no text for it."""
        return str(self.words.get(f"{group}.{name}", name))

    def score(self, value: float) -> str:
        """Format a score as in the paper's tables, with three decimals."""
        return self._localised(f"{value:.3f}")

    def difference(self, value: float) -> str:
        """Format a difference of scores with its sign and three decimals."""
        text = self._localised(f"{abs(value):.3f}")
        return text if float(f"{value:.3f}") == 0.0 else f"{'+' if value > 0.0 else MINUS}{text}"

    def p_value(self, p: float) -> str:
        """Format a p-value with three decimals."""
        return self._localised(f"< {0.001:.3f}" if p < 0.001 else f"{p:.3f}")

    def percent(self, share: float) -> str:
        """Format a fraction in [0, 1] in whole percent; only 1 gives 100% and only 0 gives 0%.

        Less than half a percent is "< 1%", so that it agrees with a score of 0.000 beside it.
        """
        bounded = min(max(round(100 * share), 1), 99) if 0 < share < 1 else round(100 * share)
        below = "< " if 0 < share < 0.005 else ""
        return below + self("format.percent", number=bounded)

    def whole(self, number: int) -> str:
        """Format a whole number, with its digits grouped as is usual in the language."""
        first, further = self.words["format.groups"]
        digits, parts = str(number), []
        size = first
        while len(digits) > size:
            digits, part = digits[:-size], digits[-size:]
            parts.append(part)
            size = further
        return self("format.group_mark").join([digits, *reversed(parts)])

    def decimal(self, number: float) -> str:
        """Format a number with at most two decimals."""
        if number.is_integer():
            return self.whole(int(number))
        return self._localised(f"{number:.2f}".rstrip("0").rstrip("."))

    def amount(self, number: float) -> str:
        """Format a number of any size with at most three significant digits, such as 0.0312, 45,000 or 7×10⁹."""
        if number == 0.0:
            return self.whole(0)
        mantissa, _, power = f"{number:.2e}".partition("e")
        if 1e-4 <= number < 999_500:
            rounded = float(f"{number:.3g}")
            if rounded.is_integer():
                return self.whole(int(rounded))
            return self._localised(f"{rounded:.8f}".rstrip("0"))
        digits = self._localised(mantissa.rstrip("0").rstrip("."))
        raised = str(int(power)).translate(_RAISED)
        return f"10{raised}" if digits == "1" else f"{digits}×10{raised}"

    def date(self, time: datetime) -> str:
        """Format a date."""
        month = self.words["format.months"][time.month - 1]
        return self("format.date", day=time.day, month=month, year=time.year)

    def moment(self, time: datetime) -> str:
        """Format a date and the time of day, in UTC."""
        return self("format.moment", date=self.date(time), time=f"{time:%H:%M}")

    def _localised(self, number: str) -> str:
        return number.replace(".", self("format.decimal_mark"))


@cache
def all_texts() -> dict[str, PageTexts]:
    """Return the texts of every language that has a file, by code; the default language first."""
    codes = sorted((path.stem for path in FOLDER.glob("*.toml")), key=lambda code: (code != DEFAULT_LANGUAGE, code))
    return {code: read_texts(FOLDER / f"{code}.toml") for code in codes}


def read_texts(path: Path) -> PageTexts:
    """Read the texts in a file named after the language's code."""
    return PageTexts(path.stem, dict(_flat(tomllib.loads(path.read_text(encoding="utf-8")))))


def preferred_language(accepted: str) -> str:
    """Return the best available language for a browser.

    Args:
        accepted: the browser's `Accept-Language`, such as `hi-IN, hi;q=0.9, en;q=0.8`.
    """
    preferences = []
    for place, part in enumerate(accepted.split(",")):
        tag, _, weight = part.strip().partition(";q=")
        try:
            preferences.append((-float(weight or 1), place, tag.partition("-")[0].lower()))
        except ValueError:
            continue
    return next(
        (code for weight, _, code in sorted(preferences) if weight < 0 and code in all_texts()), DEFAULT_LANGUAGE
    )


def _flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for key, value in table.items():
        pairs += _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else [(f"{prefix}{key}", value)]
    return pairs
