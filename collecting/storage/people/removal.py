"""Deletion of a person's data, and of the traces that it would leave on the disk."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.storage.people.records import FORGOTTEN, LEFT, Worker
from arramon_collecting.storage.records import Collection, record_of
from arramon_collecting.storage.texts.records import WITHDRAWN
from arramon_collecting.storage.transactions import Clock, lock, utc_now
from arramon_collecting.storage.work.records import OPEN, RETURNED
from arramon_server.errors import Conflict, NotFound, quoted
from arramon_server.runs.storage.collection_tables import (
    drafts,
    mail,
    sign_ins,
    tasks,
    texts,
    verifications,
    visits,
    workers,
)
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.pruning import delete_runs
from arramon_server.runs.storage.tables import runs


@dataclass(frozen=True, slots=True)
class Removed:
    """What was deleted of a person.

    Attributes:
        worker_id: the pseudonym, which the remaining rows keep.
        runs: number of runs of verifications, with all their steps.
        texts: number of texts that were deleted; 0 if the person left them.
        kept_texts: number of texts that stay, as the person agreed.
    """

    worker_id: str
    runs: int
    texts: int
    kept_texts: int


class Removal:
    """Leaving, and deletion.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def leave(self, worker: Worker) -> None:
        """Record that a worker left: the open task goes back to the pool, and all browsers are signed out.

        The personal link stays valid, so that the worker can come back, or delete the data.
        """
        with self._database.write() as connection:
            lock(connection, worker.collection)
            _return_tasks(connection, worker.worker_id, self._clock())
            mine = workers.c.worker_id == worker.worker_id, workers.c.state != FORGOTTEN
            connection.execute(workers.update().where(*mine).values(state=LEFT))
            connection.execute(sign_ins.delete().where(sign_ins.c.worker_id == worker.worker_id))

    def forget(self, collection: Collection, worker_id: str, *, keep_texts: bool | None = None) -> Removed:
        """Delete a person's data, and overwrite it on the disk where the database allows it.

        There remain: the pseudonym; when and to what the person agreed; the amounts of the ledger; which episodes were
        done; and the scores of verifications, on which others' texts were kept or not. The texts remain if the person
        agreed to that; a later call with `keep_texts=False` deletes them, too.

        Args:
            collection: the person's collection.
            worker_id: the person's pseudonym.
            keep_texts: whether the texts remain; None for what the person asked for.

        Raises:
            NotFound: if the collection has no such worker.
            Conflict: if the data was deleted already, and there are no texts to delete.
        """
        with self._database.erase() as connection:
            lock(connection, collection.name)
            query = sa.select(workers).where(workers.c.worker_id == worker_id, workers.c.collection == collection.name)
            if (row := connection.execute(query).first()) is None:
                raise NotFound(f"there is no worker {quoted(worker_id)} in collection {collection.name!r}")
            worker = record_of(Worker, row)
            if worker.state == FORGOTTEN and not (worker.keep_texts and keep_texts is False):
                texts_too = "the texts stay" if worker.keep_texts else "with all texts"
                raise Conflict(f"the data of worker {worker_id!r} was deleted already; {texts_too}")
            keeps = bool(worker.keep_texts if keep_texts is None else keep_texts)
            _return_tasks(connection, worker_id, self._clock())
            deleted = _delete_work(connection, collection.name, worker_id)
            count = _remove_texts(connection, worker_id, keeps=keeps)
            for table in (sign_ins, mail, visits):
                connection.execute(table.delete().where(table.c.worker_id == worker_id))
            wiped: dict[str, Any] = {
                "state": FORGOTTEN,
                "link_hash": None,
                "external_id": None,
                "note": "",
                "email": "",
                "page_language": "",
                "screening": {},
                "placement_passed_at": None,
                "device": {},
                "keep_texts": keeps,
            }
            connection.execute(workers.update().where(workers.c.worker_id == worker_id).values(**wiped))
        return Removed(worker_id, deleted, 0 if keeps else count, count if keeps else 0)


def _return_tasks(connection: Connection, worker_id: str, now: datetime) -> None:
    mine = tasks.c.worker_id == worker_id, tasks.c.state == OPEN
    connection.execute(tasks.update().where(*mine).values(state=RETURNED, ended_at=now))


def _delete_work(connection: Connection, collection: str, worker_id: str) -> int:
    """Delete drafts, positions, walks and runs of a worker; return the number of runs."""
    ids = [row.task_id for row in connection.execute(sa.select(tasks.c.task_id).where(tasks.c.worker_id == worker_id))]
    for task_id in ids:
        connection.execute(drafts.delete().where(drafts.c.task_id == task_id))
    its = verifications.c.worker_id == worker_id
    connection.execute(verifications.update().where(its).values(path=[], placed_cells=[], run_id="", seconds=0.0))
    wiped = {"position": {}, "active_seconds": 0.0, "run_id": None, "submission_id": None}
    connection.execute(tasks.update().where(tasks.c.worker_id == worker_id).values(**wiped))
    names = [split_of_task(collection, task_id) for task_id in ids]
    found = [row.run_id for row in connection.execute(sa.select(runs.c.run_id).where(runs.c.split.in_(names)))]
    delete_runs(connection, found)
    return len(found)


def _remove_texts(connection: Connection, worker_id: str, *, keeps: bool) -> int:
    """Delete the texts of a worker, or only what was recorded of how they were written; return their number."""
    wiped: dict[str, Any] = {"evidence": {}, "history": []}
    if not keeps:
        wiped |= {"instructions": [], "failures": [], "reason": "", "state": WITHDRAWN}
    return connection.execute(texts.update().where(texts.c.worker_id == worker_id).values(**wiped)).rowcount


def split_of_task(collection: str, task_id: str) -> str:
    """Return the name of the split on which a verification is played, so that its runs are found."""
    return f"collecting/{collection}/{task_id}"
