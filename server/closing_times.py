"""Closing times of the splits' leaderboards, and whether scores are withheld until then."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from arramon_server.errors import Conflict
from arramon_server.split_times import NO_TIMES, SplitTimes


def _now() -> datetime:
    return datetime.now(UTC)


@dataclass(frozen=True, slots=True)
class ClosingTimes:
    """Closing times of the splits' leaderboards.

    Attributes:
        closes: closing times by split.
        frozen: whether leaderboards with a closing time are frozen until then: scores are shown only to a run's own
            participant and to hosts.
        now: returns the current time, in UTC.
    """

    closes: SplitTimes = NO_TIMES
    frozen: bool = False
    now: Callable[[], datetime] = _now

    def of(self, split: str) -> datetime | None:
        """Return the closing time of a split's leaderboard, in UTC; None if it stays open."""
        return self.closes.of(split)

    def is_closed(self, split: str) -> bool:
        """Return whether the leaderboard of a split is closed."""
        time = self.closes.of(split)
        return time is not None and self.now() >= time

    def is_frozen(self, split: str) -> bool:
        """Return whether the scores of a split are still withheld from everybody but a run's participant and hosts."""
        return self.frozen and self.closes.of(split) is not None and not self.is_closed(split)

    def check_open(self, split: str, consequence: str) -> None:
        """Check that the leaderboard of a split is not closed.

        Args:
            split: name of the split.
            consequence: consequence for the error message, such as "no runs are created on it".

        Raises:
            Conflict: if it is closed.
        """
        if self.is_closed(split):
            closed = format_time(self.closes.of(split))
            raise Conflict(f"the leaderboard of split {split!r} closed on {closed}: {consequence}")

    def check_shown(self, split: str) -> None:
        """Check that the scores of a split are shown.

        Raises:
            Conflict: if its leaderboard is frozen.
        """
        if self.is_frozen(split):
            raise Conflict(
                f"the leaderboard of split {split!r} is frozen: scores are shown when it closes, on "
                f"{format_time(self.closes.of(split))}"
            )


NEVER_CLOSES = ClosingTimes()
"""All leaderboards stay open."""


def format_time(time: datetime | None) -> str:
    """Format a time for an error message."""
    return f"{time:%Y-%m-%d at %H:%M} UTC" if time is not None else "no date"
