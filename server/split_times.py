"""Settings with a time for some splits, such as when their leaderboards close."""

import json
import re
from dataclasses import dataclass
from datetime import UTC, datetime

_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class SplitTimes:
    """Times of some splits.

    Attributes:
        named: pairs of a split's name and its time in UTC, sorted by name.
    """

    named: tuple[tuple[str, datetime], ...] = ()

    @classmethod
    def parse(cls, text: str) -> "SplitTimes":
        """Parse a text such as `test_unseen=2030-12-01T12:00Z`, or several of these, separated by commas.

        A date without a time means its start (00:00), and times without a zone are in UTC.

        Raises:
            ValueError: if the text is malformed, or gives a split two times.
        """
        found: dict[str, datetime] = {}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, time = part.rpartition("=")
            name = name.strip()
            if not name or name in found:
                raise ValueError(part)
            parsed = datetime.fromisoformat(time.strip())
            found[name] = parsed.astimezone(UTC) if parsed.tzinfo else parsed.replace(tzinfo=UTC)
        return cls(tuple(sorted(found.items())))

    def of(self, split: str) -> datetime | None:
        """Return the time of a split; None if it has none."""
        return dict(self.named).get(split)

    @property
    def splits(self) -> tuple[str, ...]:
        """Names of the splits that have a time."""
        return tuple(name for name, _ in self.named)

    def __str__(self) -> str:
        return ",".join(f"{name}={_written(time)}" for name, time in self.named)

    def as_toml(self) -> str:
        """Return the value as TOML: an inline table, or an empty text."""
        if not self.named:
            return '""'
        pairs = (f"{_key(name)} = {_written(time)}" for name, time in self.named)
        return "{" + ", ".join(pairs) + "}"


NO_TIMES = SplitTimes()


def _written(time: datetime) -> str:
    return time.isoformat(timespec="seconds").replace("+00:00", "Z")


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)
