"""Pruning: delete old runs that were never published, but keep counting them as attempts of their participants."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from datetime import timedelta

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import BadInput
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.causes import SERVER_FAULT
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal, run_of
from arramon_server.runs.storage.records import CANCELLED, COMPLETE, Run

MIN_DAYS, MAX_DAYS = 1, 36_500
"""Age of the runs that can be pruned, in days. Younger ones count for a participant's limit of runs a day."""

PRUNABLE_STATES = (COMPLETE, CANCELLED)
"""States of the runs that can be pruned. A running one can be cancelled first."""

_DETAILS = (
    tables.step_notes,
    tables.steps,
    tables.episodes,
    tables.images,
    tables.streams,
    tables.receipts,
    tables.superseded_receipts,
    tables.rescored_runs,
)
"""Tables with rows of a run, each before those that it refers to."""


@dataclass(frozen=True, slots=True)
class PruneFilter:
    """Selection of runs to prune.

    Attributes:
        days: minimum number of days since they ended.
        states: states of the runs, of PRUNABLE_STATES.
        split, participant: only runs on this split, or shown under this name; None for any.
        with_receipts: whether to prune runs that have a receipt too, and the stored receipt with them.
    """

    days: float
    states: Collection[str] = PRUNABLE_STATES
    split: str | None = None
    participant: str | None = None
    with_receipts: bool = False

    def __post_init__(self) -> None:
        if not MIN_DAYS <= self.days <= MAX_DAYS:
            raise BadInput(f"runs older than {self.days:g} days were requested, expected {MIN_DAYS} to {MAX_DAYS}")


@dataclass(frozen=True, slots=True)
class PrunedRun:
    """A run that was or could be pruned, and the number of its recorded steps."""

    run: Run
    steps: int


class Pruner:
    """Prunes runs, even while servers run: it deletes ended runs only, each in its own transaction.

    A run that is or ever was on the leaderboard is never pruned. Of a pruned run, the database keeps its id,
    participant, split, language and time, for the numbers of attempts and the limits.

    Args:
        database: database of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._journal = Journal(database)

    def find(self, selection: PruneFilter) -> list[PrunedRun]:
        """Return the runs that can be pruned, oldest first."""
        c = tables.runs.c
        latest = self._journal.time() - timedelta(days=selection.days)
        conditions = [c.state.in_(selection.states), c.ended_at <= latest, _is_unpublished()]
        conditions += [c[name] == value for name in ("split", "participant") if (value := getattr(selection, name))]
        if not selection.with_receipts:
            conditions.append(_has_no_receipt())
        query = sa.select(tables.runs).where(*conditions).order_by(c.created_at, c.run_id)
        return [PrunedRun(run, self._steps(run.run_id)) for run in map(run_of, self._database.read(query))]

    def prune(self, selection: PruneFilter) -> Iterator[PrunedRun]:
        """Delete the runs that can be pruned, and yield each deleted run.

        Raises:
            StorageError: if the journal cannot be written; runs that were yielded stay deleted.
        """
        for found in self.find(selection):
            if self._prune(found.run, with_receipts=selection.with_receipts):
                yield found

    def compact(self) -> None:
        """Return the space of deleted rows to the file system (SQLite) or to the tables (PostgreSQL).

        With SQLite the file is rewritten; servers wait with their writes meanwhile.

        Raises:
            StorageError: if the journal cannot be written.
        """
        self._database.vacuum()

    def _steps(self, run_id: str) -> int:
        return self._journal.progress(run_id).steps

    def _prune(self, run: Run, *, with_receipts: bool) -> bool:
        """Delete one run; return False if it cannot be pruned any more, as it may have been published meanwhile."""
        with self._database.write() as connection:
            if not self._take(connection, run, with_receipts=with_receipts):
                return False
            connection.execute(tables.pruned_runs.insert(), [_kept(connection, run)])
            delete_runs(connection, [run.run_id])
        return True

    @staticmethod
    def _take(connection: Connection, run: Run, *, with_receipts: bool) -> bool:
        """Lock a run until the transaction ends; return whether it can be pruned."""
        mine = sa.select(tables.runs.c.run_id).where(tables.runs.c.run_id == run.run_id)
        # First, as a statement that waits for a lock would test the conditions as they were before.
        connection.execute(mine.with_for_update())
        query = mine.where(_is_unpublished())
        if not with_receipts:
            query = query.where(_has_no_receipt())
        return bool(connection.execute(query).all())


def delete_runs(connection: Connection, run_ids: Collection[str]) -> None:
    """Delete runs that were never published, with everything that is recorded of them."""
    for run_id in run_ids:
        for table in (*_DETAILS, tables.runs):
            connection.execute(table.delete().where(table.c.run_id == run_id))


def _kept(connection: Connection, run: Run) -> dict[str, object]:
    c = tables.episodes.c
    faults = sa.select(sa.func.count()).where(c.run_id == run.run_id, c.cause == SERVER_FAULT)
    columns = (column.name for column in tables.pruned_runs.columns if column.name != "had_fault")
    return {name: getattr(run, name) for name in columns} | {"had_fault": bool(connection.execute(faults).scalar())}


def _is_unpublished() -> sa.ColumnElement[bool]:
    return ~sa.exists().where(tables.entries.c.run_id == tables.runs.c.run_id).correlate(tables.runs)


def _has_no_receipt() -> sa.ColumnElement[bool]:
    return ~sa.exists().where(tables.receipts.c.run_id == tables.runs.c.run_id).correlate(tables.runs)
