"""Cancellation of runs from outside the server process, whether or not it is running."""

import uuid
from contextlib import closing
from pathlib import Path

from arramon_server.episodes.splits import no_splits_error, read_split, split_folder, split_folders
from arramon_server.errors import Conflict
from arramon_server.runs.play.forfeits import Forfeits
from arramon_server.runs.play.session_loader import SessionLoader
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CANCELLED, RUNNING, Run


class Canceller:
    """Cancels runs; server processes that play them notice within a second.

    Args:
        database: database of the journal.
        data: data folder with the splits, which are needed to score the episodes.
    """

    def __init__(self, database: Database, data: Path) -> None:
        self._journal = Journal(database)
        self._data = data
        self._worker = uuid.uuid4().hex

    def cancel(self, run_id: str) -> Run:
        """Forfeit the remaining episodes of a run, and return the cancelled run.

        Raises:
            NotFound: if there is no run with that id, or no split in the data folder.
            Conflict: if the run has ended already.
            BadFile: if a file of its split is malformed.
            StorageError: if the journal cannot be written.
        """
        run = self._journal.run(run_id)
        if run.state != RUNNING:
            raise Conflict(f"run {run_id!r} is already {run.state.lower()}")
        names = [folder.name for folder in split_folders(self._data)]
        if not names:
            raise no_splits_error(self._data)
        splits = {run.split: read_split(split_folder(self._data, run.split))} if run.split in names else {}
        with closing(Worlds(splits)) as worlds:
            forfeits = Forfeits(self._journal, SessionLoader(splits, self._journal, worlds), self._worker)
            try:
                self._journal.beat(self._worker)  # Other processes do not take what a live process has claimed.
                while forfeits.cancel_some(run, "the host cancelled the run"):
                    self._journal.beat(self._worker)
            finally:
                self._journal.retire(self._worker)
        self._mark_cancelled(run_id)
        return self._journal.run(run_id)

    def _mark_cancelled(self, run_id: str) -> None:
        """Set the state of a run without remaining episodes to cancelled."""
        self._journal.set_state(run_id, CANCELLED)
