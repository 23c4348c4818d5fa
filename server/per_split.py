"""Integer settings that may differ by split, such as the number of runs that a participant may create per day."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass

DEFAULT = "default"
"""Key of the number for all splits that are not named."""

MAX_LIMIT = 1_000_000_000
"""Maximum value of a limit of runs or streams."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class PerSplit:
    """A default number, and different numbers for some splits.

    Attributes:
        default: number for splits that are not in `named`; None for the server's default.
        named: pairs of split name and number, sorted by name.
    """

    default: int | None = None
    named: tuple[tuple[str, int], ...] = ()

    @classmethod
    def parse(cls, text: str) -> "PerSplit":
        """Parse a text such as `3`, `test_unseen=3`, or `5,test_unseen=3,val_seen=0`.

        Raises:
            ValueError: if the text is malformed, or gives a split two numbers.
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
        """Return the number for a split; None if none was given."""
        return dict(self.named).get(split, self.default)

    @property
    def splits(self) -> tuple[str, ...]:
        """Names of the splits with numbers of their own."""
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
