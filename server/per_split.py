"""Integer settings that may differ by split, such as the number of runs that a participant may create in a day."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass

DEFAULT = "default"
"""Key for all splits without a number of their own."""

MAX_LIMIT = 1_000_000_000
"""Maximum value of a limit of runs or streams."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class PerSplit:
    """Default number for all splits, and numbers for some splits.

    Attributes:
        default: number of each split that is not in `named`; None if that is left to the server.
        named: pairs of a split's name and its number, sorted by name.
    """

    default: int | None = None
    named: tuple[tuple[str, int], ...] = ()

    @classmethod
    def parse(cls, text: str) -> "PerSplit":
        """Parse a text such as `3`, `test_unseen=3`, or `5,test_unseen=3,val_seen=0`.

        Raises:
            ValueError: if the text has another form, or gives a split two numbers.
        """
        found: dict[str, int] = {}
        for part in text.split(","):
            name, _, number = (DEFAULT + "=" + part if "=" not in part else part).rpartition("=")
            name, number = name.strip(), number.strip()
            if not name or name in found or not (number.isascii() and number.isdecimal()):
                raise ValueError(part)
            found[name] = int(number)
        default = found.pop(DEFAULT, None)
        return cls(default, tuple(sorted(found.items())))

    def of(self, split: str) -> int | None:
        """Return the number of a split; None if none was given for it."""
        return dict(self.named).get(split, self.default)

    @property
    def splits(self) -> tuple[str, ...]:
        """Names of the splits that have a number of their own."""
        return tuple(name for name, _ in self.named)

    @property
    def numbers(self) -> tuple[int, ...]:
        """All numbers that were given, the default first."""
        return (*(() if self.default is None else (self.default,)), *(number for _, number in self.named))

    def __str__(self) -> str:
        parts = [f"{name}={number}" for name, number in self.named]
        return ",".join(parts if self.default is None else [str(self.default), *parts])

    def as_toml(self) -> str:
        """Return the value as TOML: a number or an inline table."""
        if not self.named:
            return "{}" if self.default is None else str(self.default)
        default = {} if self.default is None else {DEFAULT: self.default}
        table: Mapping[str, int] = {**default, **dict(self.named)}
        return "{" + ", ".join(f"{_key(name)} = {number}" for name, number in table.items()) + "}"


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)
