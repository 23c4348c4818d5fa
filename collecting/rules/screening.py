"""The screening tests: their right answers, and how many attempts there are before an explanation and a pause.

Pure. The result of a stage is stored with the worker as `{"attempts": 1, "passed_at": TIME, "until": TIME}`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

CHOICES = ("a", "b", "c")
"""Choices of each question."""

RIGHT_WRITE: Mapping[str, str] = {"q1": "c", "q2": "a", "q3": "b", "q4": "c", "q5": "b"}
"""Right answers of the test before writing, by question; words: `collect_screening_write` in the texts."""

RIGHT_VERIFY: Mapping[str, str] = {"q1": "b", "q2": "c", "q3": "a", "q4": "b"}
"""Right answers of the test before the first verification; words: `collect_screening_verify`."""

RIGHT_ANSWERS = {"write": RIGHT_WRITE, "verify": RIGHT_VERIFY}
"""Right answers of each stage's test."""


@dataclass(frozen=True, slots=True)
class Screening:
    """How a worker stands in the test of one stage.

    Attributes:
        attempts: failed attempts since the last pause.
        passed_at: when the test was passed; None before.
        until: end of the latest pause; None if there was none.
    """

    attempts: int = 0
    passed_at: datetime | None = None
    until: datetime | None = None

    @classmethod
    def stored(cls, result: Mapping[str, Any]) -> "Screening":
        """Return a stored result; an empty one is that of a worker who has not tried."""
        passed_at, until = (result.get(name) for name in ("passed_at", "until"))
        return cls(
            int(result.get("attempts", 0)),
            datetime.fromisoformat(passed_at) if passed_at else None,
            datetime.fromisoformat(until) if until else None,
        )

    def as_stored(self) -> dict[str, Any]:
        """Return the result as it is stored."""
        times = {"passed_at": self.passed_at, "until": self.until}
        return {"attempts": self.attempts} | {name: at.isoformat() if at else None for name, at in times.items()}

    def is_paused(self, now: datetime) -> bool:
        """Return whether the worker has to wait before the next attempt."""
        return self.passed_at is None and self.until is not None and now < self.until

    def answered(self, *, is_right: bool, now: datetime, attempts: int, pause: timedelta) -> "Screening":
        """Return the result after an attempt.

        Args:
            is_right: whether all answers were right.
            now: the time.
            attempts: attempts before a pause.
            pause: the pause; afterwards the attempts start again.
        """
        if self.passed_at is not None or self.is_paused(now):
            return self
        if is_right:
            return Screening(self.attempts, now, self.until)
        if self.attempts + 1 >= attempts:
            return Screening(0, None, now + pause)
        return Screening(self.attempts + 1, None, self.until)


def wrong_answers(answers: Mapping[str, str], right: Mapping[str, str]) -> tuple[str, ...]:
    """Return the questions that were answered wrongly or not at all, in order."""
    return tuple(question for question, choice in right.items() if answers.get(question) != choice)
