"""Clocks of play: a time limit per step, and a time bank per run, which overdue steps are charged to.

The time of a step begins when its observation is handed to the transport: drawing and commits cost a player nothing.
It ends with the answer, whether or not the client reads and stays connected; while no stream has the episode, the
journal holds the time. Overdue time is charged once per stream, however many of its episodes are overdue at once.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from heapq import heappop, heappush
from math import inf

from arramon_server.runs.storage.records import Run

STALL_SECONDS = 3.0
"""Longest interval between readings of the clock (normally a second) that counts; a longer one is a server stall."""


class PlayClock:
    """Monotonic clock of play, in seconds, that excludes time during which the server stalled.

    Args:
        source: monotonic clock of the machine, in seconds.
    """

    def __init__(self, source: Callable[[], float] = time.monotonic) -> None:
        self._source = source
        self._seen = source()
        self._stood_still = 0.0

    def __call__(self) -> float:
        """Return the time, in seconds since an arbitrary moment."""
        now = self._source()
        if now - self._seen > STALL_SECONDS:
            self._stood_still += now - self._seen
        self._seen = now
        return now - self._stood_still


@dataclass(frozen=True, slots=True)
class ClockSettings:
    """Time limits of a run, in seconds.

    Attributes:
        step_seconds: limit of each step; 0 for no time limits.
        bank_seconds: limit of the total overdue time of all steps.
    """

    step_seconds: float = 0.0
    bank_seconds: float = 0.0

    @classmethod
    def of(cls, run: Run) -> "ClockSettings":
        """Return the time limits of a run."""
        return cls(run.step_seconds, run.bank_seconds)

    def __bool__(self) -> bool:
        """Return whether there are time limits."""
        return self.step_seconds > 0.0

    def __str__(self) -> str:
        """Return the limits as in a score signature, such as "60/86400", or "none"."""
        return f"{self.step_seconds:.12g}/{self.bank_seconds:.12g}" if self else "none"


@dataclass(slots=True)
class Bank:
    """Seconds left in the bank of a run, as this process knows it; shared by all streams of the run."""

    left: float


@dataclass(frozen=True, slots=True)
class TimeLeft:
    """Time left for an action, in seconds: for its step, and in the bank."""

    step_seconds: float
    bank_seconds: float


@dataclass(slots=True)
class _StepClock:
    """Clock of the current step of an open episode.

    Attributes:
        number: number of the step.
        waited: seconds from when its observation was first sent to when this stream got the episode.
        began: time at which the observation was sent, or this stream got it back; infinite before.
        due: time at which the step is overdue; infinite before it begins.
    """

    number: int
    waited: float = 0.0
    began: float = inf
    due: float = inf


class StreamClock:
    """Clocks of all open episodes of one stream.

    Args:
        step_seconds: time limit of each step, in seconds.
        bank: bank of the run.
        now: returns the time of play, in seconds.
    """

    def __init__(self, step_seconds: float, bank: Bank, now: Callable[[], float]) -> None:
        self.bank = bank
        self._step_seconds = step_seconds
        self._now = now
        self._steps: dict[str, _StepClock] = {}
        self._dues: list[tuple[float, str]] = []
        self._charged = -inf
        self._owed = 0.0

    def open(self, episode_id: str, number: int, waited: float | None = None) -> None:
        """Add an episode to the stream.

        Args:
            episode_id: id of the episode.
            number: number of its present step.
            waited: seconds since the observation of that step was first sent, charged until now; None if it was not.
        """
        self._steps[episode_id] = step = _StepClock(number, waited or 0.0)
        if waited is not None:
            self._begin(episode_id, step)

    def close(self, episode_id: str) -> None:
        """Remove an episode from the stream. Its overdue time must have been charged before."""
        self._steps.pop(episode_id, None)

    def send(self, observations: Iterable[tuple[str, int]]) -> None:
        """Start the steps whose observations go to the transport now, given as pairs of episode id and step number."""
        for episode_id, number in observations:
            step = self._steps.get(episode_id)
            if step is not None and step.number == number:
                self._begin(episode_id, step)

    def begin_all(self) -> None:
        """Start all steps, because the client does not read the messages before their observations."""
        for episode_id, step in self._steps.items():
            self._begin(episode_id, step)

    def answer(self, episode_id: str, number: int) -> None:
        """Stop the clock of an answered step. Its overdue time must have been charged before."""
        self._steps[episode_id] = _StepClock(number + 1)

    def charge(self, at: float) -> None:
        """Charge the bank for the overdue time until `at`, less what was charged before."""
        start = max(self._first_due(), self._charged)
        if at > start:
            self._charged = at
            self._owed += at - start
            self.bank.left = max(0.0, self.bank.left - (at - start))

    def take_charges(self) -> float:
        """Return the seconds charged since the last call, which the caller must write to the journal."""
        owed, self._owed = self._owed, 0.0
        return owed

    def out_of_time(self, at: float) -> list[str]:
        """Return the episodes that are overdue at a time if the bank is empty; call `charge` before."""
        if self.bank.left > 0.0 or at <= self._first_due():
            return []
        return [episode_id for episode_id, step in self._steps.items() if step.due < at]

    def time_left(self, episode_id: str) -> TimeLeft:
        """Return the time left for an episode's current step."""
        step = self._steps[episode_id]
        running = self._granted(step) if step.began == inf else step.due - self._now()
        return TimeLeft(max(0.0, running), self.bank.left)

    def waiting_times(self) -> dict[str, tuple[int, float | None]]:
        """Return each episode's step number and the seconds since its observation was first sent, None if never."""
        now = self._now()
        return {
            episode_id: (step.number, None if step.began == inf else step.waited + now - step.began)
            for episode_id, step in self._steps.items()
        }

    def _begin(self, episode_id: str, step: _StepClock) -> None:
        if step.began == inf:
            step.began = self._now()
            step.due = step.began + self._granted(step)
            heappush(self._dues, (step.due, episode_id))

    def _granted(self, step: _StepClock) -> float:
        return max(0.0, self._step_seconds - step.waited)

    def _first_due(self) -> float:
        """Return the earliest due time of all steps; infinite if none is due."""
        while self._dues and (
            self._dues[0][1] not in self._steps or self._steps[self._dues[0][1]].due != self._dues[0][0]
        ):
            heappop(self._dues)
        return self._dues[0][0] if self._dues else inf
