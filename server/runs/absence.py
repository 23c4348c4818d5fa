"""How long a run's episodes wait for players who have left: nobody thinks for ever by hanging up.

A client that dies or loses its connection is not charged, within `clocks.AWAY_SECONDS` in all. Only a process that runs
counts, by the clock of play: the server's own absences cost nobody anything, and neither do wall clocks that jump.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from server.runs.journal import Journal
from server.runs.ledger import Ledger

FIRST_SECONDS, AGAIN_SECONDS = 1.0, 10.0
"""After which it is looked whether players are back, and between two further looks."""


@dataclass(slots=True)
class _Absence:
    """Episodes, with the epochs of their claims, that one stream has left; counted until a time, looked at from one."""

    run_id: str
    epochs: Mapping[str, int]
    counted: float
    due: float


class Absences:
    """All absences that began at this process.

    Args:
        journal: says who holds what.
        ledger: keeps how long it was, in all.
        now: the time, in seconds since some moment.
    """

    def __init__(self, journal: Journal, ledger: Ledger, now: Callable[[], float]) -> None:
        self._now = now
        self._journal = journal
        self._ledger = ledger
        self._absent: list[_Absence] = []

    def begin(self, run_id: str, epochs: Mapping[str, int]) -> None:
        """A stream has left these episodes just now."""
        now = self._now()
        if epochs:
            self._absent.append(_Absence(run_id, epochs, now, now + FIRST_SECONDS))

    def count(self) -> None:
        """Writes down what has passed, and forgets those whose episodes somebody plays or has ended.

        Raises:
            StorageError: if the journal cannot be read or written; nothing is lost by that.
        """
        now = self._now()
        for absence in [absence for absence in self._absent if absence.due <= now]:
            claims = self._journal.open_claims(absence.run_id)
            waiting = any(c.worker is None and absence.epochs.get(c.episode_id) == c.epoch for c in claims)
            self._ledger.absent(absence.run_id, now - absence.counted)
            absence.counted, absence.due = now, now + AGAIN_SECONDS
            if not waiting:
                self._absent.remove(absence)
