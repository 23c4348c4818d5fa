"""Visits of workers from a crowd platform, and the list to reconcile with the platform's own."""

from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sa

from arramon_collecting.storage.people.records import Visit, Worker
from arramon_collecting.storage.records import Collection, first_record, record_of
from arramon_collecting.storage.transactions import Clock, lock, new_id, utc_now
from arramon_collecting.storage.work.records import SUBMITTED
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.collection_tables import ledger, tasks, visits, workers
from arramon_server.runs.storage.database import Database, utc


@dataclass(frozen=True, slots=True)
class VisitAccount:
    """A visit with what came of it.

    Attributes:
        external_id: the platform's id of the worker; empty if the worker's data was deleted.
        visit: the visit.
        submitted: number of tasks submitted since it began.
        last_at: when the last one was; None for none.
        amount_minor: amount that the collection owes the worker, over all visits.
        state: "complete", "returned", or "left" while the completion code is not out.
    """

    external_id: str
    visit: Visit
    submitted: int
    last_at: datetime | None
    amount_minor: int
    state: str


class Visits:
    """Visits from crowd platforms.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def begin(self, worker_id: str, study_id: str, session_id: str) -> Visit:
        """Record a visit; return the earlier one of the same session if there is one."""
        c = visits.c
        mine = sa.select(visits).where(c.worker_id == worker_id, c.study_id == study_id, c.session_id == session_id)
        with self._database.write() as connection:
            if (row := connection.execute(mine.with_for_update()).first()) is not None:
                return record_of(Visit, row)
            begun = Visit(new_id(), worker_id, study_id, session_id, self._clock(), None, None)
            connection.execute(visits.insert(), [{name: getattr(begun, name) for name in visits.c.keys()}])  # noqa: SIM118
        return begun

    def latest(self, worker_id: str) -> Visit | None:
        """Return the worker's latest visit; None if the worker did not come from a platform."""
        query = sa.select(visits).where(visits.c.worker_id == worker_id).order_by(visits.c.joined_at.desc()).limit(1)
        return first_record(self._database, Visit, query)

    def completion_code(self, collection: Collection, worker: Worker) -> str | None:
        """Return the completion code of the worker's latest visit once the study's tasks are submitted; None before.

        It counts what is committed to the database, and records when the code was first given out.
        """
        visit = self.latest(worker.worker_id)
        study = collection.settings.platform.studies.get(visit.study_id) if visit is not None else None
        if visit is None or study is None or visit.returned_at is not None:
            return None
        if visit.completed_at is not None:
            return study.code
        submitted = sa.select(sa.func.count()).where(
            tasks.c.worker_id == worker.worker_id, tasks.c.state == SUBMITTED, tasks.c.ended_at >= visit.joined_at
        )
        with self._database.write() as connection:
            lock(connection, collection.name)
            if (connection.execute(submitted).scalar() or 0) < study.tasks:
                return None
            mine = visits.c.visit_id == visit.visit_id
            connection.execute(visits.update().where(mine).values(completed_at=self._clock()))
        return study.code

    def reconcile(self, collection: str) -> list[VisitAccount]:
        """Return all visits of a collection with what came of each, oldest first."""
        query = (
            sa.select(visits, workers.c.external_id)
            .join(workers, workers.c.worker_id == visits.c.worker_id)
            .where(workers.c.collection == collection)
            .order_by(visits.c.joined_at, visits.c.visit_id)
        )
        return [self._account(record_of(Visit, row), row.external_id or "") for row in self._database.read(query)]

    def mark_returned(self, collection: str, external_id: str) -> Worker:
        """Record that the platform lists a worker's visits as returned; return the worker.

        Raises:
            NotFound: if the collection has no such worker.
        """
        with self._database.write() as connection:
            query = sa.select(workers).where(workers.c.collection == collection, workers.c.external_id == external_id)
            if (row := connection.execute(query).first()) is None:
                raise NotFound(f"there is no worker with the platform's id {quoted(external_id)}")
            mine = visits.c.worker_id == row.worker_id
            unfinished = visits.update().where(mine, visits.c.completed_at.is_(None), visits.c.returned_at.is_(None))
            connection.execute(unfinished.values(returned_at=self._clock()))
            return record_of(Worker, row)

    def _account(self, visit: Visit, external_id: str) -> VisitAccount:
        mine = sa.select(tasks.c.ended_at).where(
            tasks.c.worker_id == visit.worker_id, tasks.c.state == SUBMITTED, tasks.c.ended_at >= visit.joined_at
        )
        times = [utc(row.ended_at) for row in self._database.read(mine.order_by(tasks.c.ended_at))]
        owed = sa.select(sa.func.coalesce(sa.func.sum(ledger.c.amount_minor), 0)).where(
            ledger.c.worker_id == visit.worker_id
        )
        amount = int(self._database.read(owed)[0][0])
        state = "complete" if visit.completed_at else "returned" if visit.returned_at else "left"
        return VisitAccount(external_id, visit, len(times), times[-1] if times else None, amount, state)
