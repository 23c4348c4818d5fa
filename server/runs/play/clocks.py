"""Clocks of play: a time limit for each step, and a bank of time for each run that overdue steps draw on.

The time of a step begins when its observation has left the server: drawing, commits and replays cost a player nothing.
Overdue time is charged once per stream, however many of its episodes are overdue at once. The time to read a delivery
is limited like that of a step, so that a client cannot stop the clocks by not reading.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from heapq import heappop, heappush
from math import inf

from server.runs.storage.records import AWAY_SECONDS, Run

STALL_SECONDS = 3.0
"""Longest interval between readings of the clock (normally a second) that counts; a longer one is a server stall."""


class Stopwatch:
    """Monotonic clock of play, in seconds, that leaves out the time for which the server stalled.

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
class Clocks:
    """Time limits of a run, in seconds.

    Attributes:
        step_seconds: limit of each step; 0 for no clocks at all.
        first_step_seconds: limit of each step that begins before the first action of the run.
        bank_seconds: total overdue time of all steps.
    """

    step_seconds: float = 0.0
    first_step_seconds: float = 0.0
    bank_seconds: float = 0.0

    @classmethod
    def of(cls, run: Run) -> "Clocks":
        """Return the time limits with which a run was created."""
        return cls(run.step_seconds, run.first_step_seconds, run.bank_seconds)

    def __bool__(self) -> bool:
        """Return whether there are clocks."""
        return self.step_seconds > 0.0

    def __str__(self) -> str:
        """Return the limits as in a score signature, such as "60/600/3600", or "none"."""
        seconds = (self.step_seconds, self.first_step_seconds, self.bank_seconds)
        return "/".join(f"{number:.12g}" for number in seconds) if self else "none"


@dataclass(slots=True)
class Bank:
    """Bank of a run, as known to this process.

    Attributes:
        left: remaining seconds.
        answered: whether the run has had its first action.
        away_left: remaining seconds of `AWAY_SECONDS`; negative once they are used up.
    """

    left: float
    answered: bool = False
    away_left: float = AWAY_SECONDS


@dataclass(frozen=True, slots=True)
class TimeLeft:
    """Remaining time for an action, in seconds: of its step, and of the bank."""

    step_seconds: float
    bank_seconds: float


@dataclass(slots=True)
class _Step:
    """Clock of an open episode's present step.

    Attributes:
        waited: seconds that the step waited on earlier streams.
        answered: number of the last step with an action; -1 for none.
        began: time at which the step began on this stream; infinite before.
        due: time at which the step is overdue; infinite before it begins.
    """

    waited: float = 0.0
    answered: int = -1
    began: float = inf
    due: float = inf


class StreamClock:
    """Clocks of all open episodes of one stream.

    Args:
        clocks: time limits of the run.
        bank: bank of the run.
        now: returns the time of play, in seconds.
    """

    def __init__(self, clocks: Clocks, bank: Bank, now: Callable[[], float]) -> None:
        self.bank = bank
        self._clocks = clocks
        self._now = now
        self._steps: dict[str, _Step] = {}
        self._dues: list[tuple[float, str]] = []
        self._queue: deque[tuple[tuple[str, int], ...]] = deque()
        self._head_since = inf
        self._charged = -inf
        self._owed = 0.0
        self._back: dict[str, float] = {}
        self._back_counted = -inf

    def open(self, episode_id: str, waited: float, away: float | None = None) -> None:
        """Add an episode to the stream.

        Args:
            episode_id: id of the episode.
            waited: seconds that its present step waited on earlier streams.
            away: seconds since the last stream released the episode; None if no player has seen it yet.
        """
        self._steps[episode_id] = step = _Step(waited)
        if away is None:
            return
        step.waited += min(away, max(0.0, -self.bank.away_left))
        granted = self._clocks.step_seconds if self.bank.answered else self._clocks.first_step_seconds
        overdue = max(0.0, step.waited - max(granted, waited))
        self._owed += overdue
        self.bank.left = max(0.0, self.bank.left - overdue)
        self._back[episode_id] = self._now()

    def unread_seconds(self, at: float) -> float:
        """Return the seconds since the last call for which resumed episodes were not delivered again; 0 below 1 s.

        They count as absence: the player has seen these observations and can think about them meanwhile.
        """
        since = max(min(self._back.values(), default=inf), self._back_counted)
        if at - since < 1.0:
            return 0.0
        self._back_counted = at
        return at - since

    def begin(self, at: float) -> None:
        """Begin the steps of all resumed episodes, whether or not they have been delivered."""
        for episode_id in self._back:
            self._begin(episode_id, at)
        self._back.clear()

    def close(self, episode_id: str) -> None:
        """Remove an episode from the stream. Its overdue time must have been charged before."""
        self._steps.pop(episode_id, None)
        self._back.pop(episode_id, None)

    def send(self, observations: Iterable[tuple[str, int]]) -> None:
        """Queue the observations of one delivery, as pairs of episode and step number, until they leave the server."""
        if not self._queue:
            self._head_since = self._now()
        self._queue.append(tuple(observations))

    def leave(self) -> None:
        """Note that the oldest queued delivery has left the server, and begin its steps."""
        now = self._now()
        self.charge(now)
        for episode_id, number in self._queue.popleft() if self._queue else ():
            step = self._steps.get(episode_id)
            if step is not None and step.began == inf and number > step.answered:
                self._begin(episode_id, now)
                self._back.pop(episode_id, None)
        self._head_since = now

    def answer(self, episode_id: str, number: int) -> None:
        """Note the action of a step. Its overdue time must have been charged before."""
        self._steps[episode_id] = _Step(answered=number)
        self._back.pop(episode_id, None)
        self.bank.answered = True

    def charge(self, at: float) -> None:
        """Charge the bank for the overdue time until `at` that was not charged yet."""
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
        """Return the episodes that are overdue at a time if the bank is empty. Call it after `charge`."""
        if self.bank.left > 0.0 or at <= self._first_due():
            return []
        out = [episode_id for episode_id, step in self._steps.items() if step.due < at]
        if self._queue and self._head_since + self._clocks.step_seconds < at:
            out += [episode_id for episode_id, step in self._steps.items() if step.began == inf]
            self._head_since = at  # episodes that replace them have their own time
        return out

    def time_left(self, episode_id: str) -> TimeLeft:
        """Return the remaining time for an episode's present step."""
        step = self._steps[episode_id]
        running = self._granted(step) if step.began == inf else step.due - self._now()
        return TimeLeft(max(0.0, running), self.bank.left)

    def waited(self) -> dict[str, float]:
        """Return the seconds that each episode's present step has waited, on this and earlier streams."""
        now = self._now()
        return {
            episode_id: step.waited + (0.0 if step.began == inf else now - step.began)
            for episode_id, step in self._steps.items()
        }

    def _begin(self, episode_id: str, at: float) -> None:
        step = self._steps[episode_id]
        step.began, step.due = at, at + self._granted(step)
        heappush(self._dues, (step.due, episode_id))

    def _granted(self, step: _Step) -> float:
        granted = self._clocks.step_seconds if self.bank.answered else self._clocks.first_step_seconds
        return max(0.0, granted - step.waited)  # overdue time before that has been charged

    def _first_due(self) -> float:
        """Return the earliest due time of all steps and of reading; infinite if nothing is due from the client."""
        while self._dues and (
            self._dues[0][1] not in self._steps or self._steps[self._dues[0][1]].due != self._dues[0][0]
        ):
            heappop(self._dues)
        reading = self._head_since + self._clocks.step_seconds if self._queue else inf
        return min(self._dues[0][0] if self._dues else inf, reading)
