"""Absences of players: how long their open episodes wait, so that nobody gains thinking time by disconnecting.

An absence is free until a run has used up `AWAY_SECONDS` in all. Only the time of running processes counts, by the
clock of play: neither the server's own absence nor a jump of the wall clock is charged to anybody.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from server.runs.storage.journal import Journal
from server.runs.storage.run_activity import RunActivity

FIRST_SECONDS, AGAIN_SECONDS = 1.0, 10.0
"""Time until an absence is first counted, and between two further counts."""


@dataclass(slots=True)
class _Absence:
    """Episodes that one stream left, with the epochs of their claims; counted up to a time, due to be counted again."""

    run_id: str
    epochs: Mapping[str, int]
    counted: float
    due: float


class Absences:
    """All absences that began at this process.

    Args:
        journal: holds the claims.
        activity: sums the absences of each run.
        now: clock of play, in seconds.
    """

    def __init__(self, journal: Journal, activity: RunActivity, now: Callable[[], float]) -> None:
        self._now = now
        self._journal = journal
        self._activity = activity
        self._absent: list[_Absence] = []

    def begin(self, run_id: str, epochs: Mapping[str, int]) -> None:
        """Start to count the absence of a stream that has just left these episodes."""
        now = self._now()
        if epochs:
            self._absent.append(_Absence(run_id, epochs, now, now + FIRST_SECONDS))

    def count(self) -> None:
        """Record the time that has passed, and forget absences whose episodes are played again or have ended.

        Raises:
            StorageError: if the journal cannot be read or written; nothing is lost, the next call catches up.
        """
        now = self._now()
        for absence in [absence for absence in self._absent if absence.due <= now]:
            claims = self._journal.open_claims(absence.run_id)
            waiting = any(c.worker is None and absence.epochs.get(c.episode_id) == c.epoch for c in claims)
            self._activity.add_absence(absence.run_id, now - absence.counted)
            absence.counted, absence.due = now, now + AGAIN_SECONDS
            if not waiting:
                self._absent.remove(absence)
