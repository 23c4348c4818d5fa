"""The two clocks of play: a time for each step, and a bank for each run of what its steps may take longer.

An observation's time begins when it has left the server: drawing, commits and replays cost a player nothing. What is
overdue is charged once for a stream, however many of its episodes are overdue together. Reading is a step too: a client
that does not take what waits for it is overdue after the same time, so that not reading stops no clock.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from heapq import heappop, heappush
from math import inf

from server.runs.records import Run

STALL_SECONDS = 3.0
"""The server looks at its clock once a second; what it missed beyond this it was held up for itself."""


class Stopwatch:
    """Seconds that pass for players: the machine's monotonic ones, without those for which the server stood still."""

    def __init__(self, source: Callable[[], float] = time.monotonic) -> None:
        self._source = source
        self._seen = source()
        self._stood_still = 0.0

    def __call__(self) -> float:
        """The time, in seconds since some moment."""
        now = self._source()
        if now - self._seen > STALL_SECONDS:
            self._stood_still += now - self._seen
        self._seen = now
        return now - self._stood_still


AWAY_SECONDS = 86_400.0
"""For which, in all, a run's episodes may wait for who has left and come back, before that is time for their steps: a
client that dies loses nothing, and who hangs up to think gains no more than this."""


@dataclass(frozen=True, slots=True)
class Clocks:
    """What a run grants, in seconds.

    Attributes:
        step_seconds: for each step; 0 for no clocks at all.
        first_step_seconds: for each step that is begun before the run's first answer.
        bank_seconds: for all that steps take longer.
    """

    step_seconds: float = 0.0
    first_step_seconds: float = 0.0
    bank_seconds: float = 0.0

    @classmethod
    def of(cls, run: Run) -> "Clocks":
        """What a run was granted when it was created."""
        return cls(run.step_seconds, run.first_step_seconds, run.bank_seconds)

    def __bool__(self) -> bool:
        """Whether there are clocks."""
        return self.step_seconds > 0.0

    def __str__(self) -> str:
        """As a signature has them, such as "60/600/3600"."""
        seconds = (self.step_seconds, self.first_step_seconds, self.bank_seconds)
        return "/".join(f"{number:.12g}" for number in seconds) if self else "none"


@dataclass(slots=True)
class Bank:
    """A run's bank, as this process knows it.

    Attributes:
        left: seconds.
        answered: whether the run has had an answer.
        away_left: what is left of `AWAY_SECONDS`; less than nothing once it is used up.
    """

    left: float
    answered: bool = False
    away_left: float = AWAY_SECONDS


@dataclass(frozen=True, slots=True)
class TimeLeft:
    """What is left for an answer, in seconds: of its own time, and of the bank."""

    step_seconds: float
    bank_seconds: float


@dataclass(slots=True)
class _Step:
    """An open episode's present step: how long it has waited on other streams, and since when it does on this one."""

    waited: float = 0.0
    answered: int = -1
    began: float = inf
    due: float = inf


class StreamClock:
    """The clocks of one stream.

    Args:
        clocks: what its run grants.
        bank: of its run.
        now: the time.
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
        """An episode is the stream's now; its present step has waited so many seconds on other streams.

        Args:
            episode_id: of it.
            waited: seconds.
            away: for which nobody had it since it was last seen; None where nobody has seen it.
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

    def unread(self, at: float) -> float:
        """Seconds, not told before, for which what came back has not left: who has seen it thinks on it. 0 below 1."""
        since = max(min(self._back.values(), default=inf), self._back_counted)
        if at - since < 1.0:
            return 0.0
        self._back_counted = at
        return at - since

    def begin(self, at: float) -> None:
        """The time of all that came back begins, whether it is read or not."""
        for episode_id in self._back:
            self._begin(episode_id, at)
        self._back.clear()

    def close(self, episode_id: str) -> None:
        """An episode is not the stream's any more. What it was overdue is to be charged before."""
        self._steps.pop(episode_id, None)
        self._back.pop(episode_id, None)

    def send(self, observations: Iterable[tuple[str, int]]) -> None:
        """Observations, by episode and step, wait together to leave the server."""
        if not self._queue:
            self._head_since = self._now()
        self._queue.append(tuple(observations))

    def leave(self) -> None:
        """What waited longest has left."""
        now = self._now()
        self.charge(now)
        for episode_id, number in self._queue.popleft() if self._queue else ():
            step = self._steps.get(episode_id)
            if step is not None and step.began == inf and number > step.answered:
                self._begin(episode_id, now)
                self._back.pop(episode_id, None)
        self._head_since = now

    def answer(self, episode_id: str, number: int) -> None:
        """A step was answered. What was overdue by then is to be charged before."""
        self._steps[episode_id] = _Step(answered=number)
        self._back.pop(episode_id, None)
        self.bank.answered = True

    def charge(self, at: float) -> None:
        """Takes from the bank what is overdue at a time and was not charged yet."""
        start = max(self._first_due(), self._charged)
        if at > start:
            self._charged = at
            self._owed += at - start
            self.bank.left = max(0.0, self.bank.left - (at - start))

    def settle(self) -> float:
        """What was charged since this was asked last, in seconds: it is to be written down."""
        owed, self._owed = self._owed, 0.0
        return owed

    def out_of_time(self, at: float) -> list[str]:
        """Episodes that are overdue at a time, where the bank is empty. To be asked after `charge`."""
        if self.bank.left > 0.0 or at <= self._first_due():
            return []
        out = [episode_id for episode_id, step in self._steps.items() if step.due < at]
        if self._queue and self._head_since + self._clocks.step_seconds < at:
            out += [episode_id for episode_id, step in self._steps.items() if step.began == inf]
            self._head_since = at  # what takes their place has its own time
        return out

    def time_left(self, episode_id: str) -> TimeLeft:
        """What is left for an episode's present step."""
        step = self._steps[episode_id]
        running = self._granted(step) if step.began == inf else step.due - self._now()
        return TimeLeft(max(0.0, running), self.bank.left)

    def waited(self) -> dict[str, float]:
        """For each episode how long its present step has waited, in seconds, over all streams."""
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
        return max(0.0, granted - step.waited)  # what it was overdue before has been charged

    def _first_due(self) -> float:
        """When the first of what the client is to do was or will be due; never where it has nothing to do."""
        while self._dues and (
            self._dues[0][1] not in self._steps or self._steps[self._dues[0][1]].due != self._dues[0][0]
        ):
            heappop(self._dues)
        reading = self._head_since + self._clocks.step_seconds if self._queue else inf
        return min(self._dues[0][0] if self._dues else inf, reading)
