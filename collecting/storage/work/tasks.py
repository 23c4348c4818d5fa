"""Tasks: given out one at a time to each worker, kept while used, and given back."""

from collections.abc import Callable, Mapping, Sequence
from datetime import timedelta
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.rules.assignment import next_gold, next_to_verify, next_to_write, wants_gold
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.people.workers import check_active
from arramon_collecting.storage.records import RUNNING, Collection, first_record, record_of
from arramon_collecting.storage.texts.records import SENT_BACK, Text
from arramon_collecting.storage.transactions import Clock, lock, new_id, random_number, utc_now
from arramon_collecting.storage.work.drafts import active_seconds, check_open
from arramon_collecting.storage.work.records import EXPIRED, OPEN, RETURNED, VERIFY, WRITE, Task
from arramon_collecting.storage.work.task_queries import (
    check_limit,
    is_free,
    known_episodes,
    open_task,
    taken_episodes,
    verifications_begun,
    waiting_texts,
)
from arramon_server.errors import Conflict, NotFound, quoted
from arramon_server.runs.storage.collection_tables import collections, tasks, texts
from arramon_server.runs.storage.database import Database


class Tasks:
    """Tasks of all collections.

    Args:
        database: the journal's database.
        clock: returns the present time.
        draw: returns random numbers in [0, 1).
    """

    def __init__(self, database: Database, clock: Clock = utc_now, draw: Callable[[], float] = random_number) -> None:
        self._database = database
        self._clock = clock
        self._draw = draw

    def claim_write(self, collection: Collection, worker: Worker, episodes: Sequence[str]) -> Task | None:
        """Return the worker's open task, or give out an episode to write for; None if there is none.

        Args:
            collection: a collection.
            worker: a worker who has agreed.
            episodes: ids of the collection's episodes, in order.

        Raises:
            Conflict: if the collection is paused or closed, or the worker's open task is of another stage.
            Forbidden: if the worker may not take tasks.
            OverQuota: if the worker has submitted as many as one may.
        """

        def choose(connection: Connection) -> Mapping[str, Any] | None:
            known = known_episodes(connection, worker.worker_id)
            chosen = next_to_write(episodes, taken_episodes(connection, collection.name), known)
            return None if chosen is None else {"episode_id": chosen}

        return self._claim(collection, worker, WRITE, choose)

    def claim_mend(self, collection: Collection, worker: Worker, text_id: str) -> Task:
        """Return the task in which the author mends a text that was sent back.

        Raises:
            NotFound: if the worker wrote no such text.
            Conflict: if it was not sent back, or the worker has another open task.
        """

        def choose(connection: Connection) -> Mapping[str, Any]:
            mine = sa.select(texts).where(texts.c.text_id == text_id, texts.c.worker_id == worker.worker_id)
            if (row := connection.execute(mine).first()) is None:
                raise NotFound(f"there is no text {quoted(text_id)} of yours")
            found = record_of(Text, row)
            if found.state != SENT_BACK:
                raise Conflict(f"the text is {found.state}, expected one that was sent back")
            return {"episode_id": found.episode_id, "text_id": text_id}

        claimed = self._claim(collection, worker, WRITE, choose, counts=False)
        assert claimed is not None
        if claimed.text_id != text_id:
            raise Conflict("there is another open task; submit it or give it back first")
        return claimed

    def claim_verify(self, collection: Collection, worker: Worker, golds: Sequence[str]) -> Task | None:
        """Return the worker's open task, or give out a text to verify, or a gold; None if there is none.

        Args:
            collection: a collection.
            worker: a worker who has agreed.
            golds: ids of the episodes with known instructions.

        Raises:
            Conflict, Forbidden, OverQuota: as for `claim_write`.
        """
        settings = collection.settings

        def choose(connection: Connection) -> Mapping[str, Any] | None:
            known = known_episodes(connection, worker.worker_id)
            begun, of_gold = verifications_begun(connection, worker.worker_id)
            chosen = next_to_verify(waiting_texts(connection, collection), worker.worker_id, known, settings.verifiers)
            if chosen is None:  # A worker who could do nothing else would notice that what comes is known.
                return None
            if wants_gold(begun, of_gold, settings.gold_share, self._draw()):
                gold = next_gold(golds, known, self._draw())
                if gold is not None and gold != chosen.episode_id:
                    return {"episode_id": gold, "is_gold": True}
            return {"episode_id": chosen.episode_id, "text_id": chosen.text_id}

        return self._claim(collection, worker, VERIFY, choose)

    def has_verify(self, collection: Collection, worker: Worker) -> bool:
        """Return whether a text waits for this worker to verify it, or an open task does."""
        with self._database.snapshot() as connection:
            known = known_episodes(connection, worker.worker_id)
            waiting = waiting_texts(connection, collection)
            is_open = open_task(connection, worker.worker_id) is not None
        needed = collection.settings.verifiers
        return is_open or next_to_verify(waiting, worker.worker_id, known, needed) is not None

    def get(self, task_id: str) -> Task:
        """Return a task.

        Raises:
            NotFound: if there is none of that id.
        """
        found = first_record(self._database, Task, sa.select(tasks).where(tasks.c.task_id == task_id))
        if found is None:
            raise NotFound(f"there is no task {quoted(task_id)}")
        return found

    def of_worker(self, worker: Worker, task_id: str) -> Task:
        """Return a worker's own task.

        Raises:
            NotFound: if the worker has none of that id.
        """
        found = self.get(task_id)
        if found.worker_id != worker.worker_id:
            raise NotFound(f"there is no task {quoted(task_id)}")
        return found

    def open_of(self, worker_id: str) -> Task | None:
        """Return a worker's open task; None if there is none."""
        query = sa.select(tasks).where(tasks.c.worker_id == worker_id, tasks.c.state == OPEN)
        return first_record(self._database, Task, query)

    def all(self, collection: str) -> list[Task]:
        """Return the tasks of a collection, oldest first."""
        query = sa.select(tasks).where(tasks.c.collection == collection).order_by(tasks.c.started_at)
        return [record_of(Task, row) for row in self._database.read(query)]

    def all_of(self, worker_id: str) -> list[Task]:
        """Return the tasks of a worker, oldest first."""
        query = sa.select(tasks).where(tasks.c.worker_id == worker_id).order_by(tasks.c.started_at)
        return [record_of(Task, row) for row in self._database.read(query)]

    def touch(self, task_id: str, position: Mapping[str, Any] | None = None) -> Task:
        """Record that a worker is active in an open task, so that it does not expire.

        Args:
            task_id: the task.
            position: where a writer stands now; None if that did not change.

        Raises:
            Conflict: if it is not open any more.
        """
        with self._database.write() as connection:
            found, now = check_open(connection, task_id), self._clock()
            active = active_seconds(found, self._clock())
            values: dict[str, Any] = {"seen_at": now, "active_seconds": active}
            if position is not None:
                values["position"] = dict(position)
            connection.execute(tasks.update().where(tasks.c.task_id == task_id).values(**values))
        return self.get(task_id)

    def set_run(self, task_id: str, before: str | None, run_id: str) -> str:
        """Record the run of an open verification, unless another tab was quicker; return the run that the task has.

        Args:
            task_id: the task.
            before: id of the run that the task had; None for none. If it has another one now, that stays.
            run_id: id of the new run.

        Raises:
            Conflict: if the task is not open any more.
        """
        with self._database.write() as connection:
            found = check_open(connection, task_id)
            if found.run_id != before:
                return found.run_id or run_id
            connection.execute(tasks.update().where(tasks.c.task_id == task_id).values(run_id=run_id))
        return run_id

    def give_back(self, task_id: str) -> Task:
        """Return an open task to the pool. Its draft is kept.

        Raises:
            Conflict: if it is not open any more.
        """
        with self._database.write() as connection:
            check_open(connection, task_id)
            ended = {"state": RETURNED, "ended_at": self._clock()}
            connection.execute(tasks.update().where(tasks.c.task_id == task_id).values(**ended))
        return self.get(task_id)

    def resume(self, task: Task) -> Task:
        """Open a task again that has expired, if nobody else does it and its worker does nothing else.

        Raises:
            Conflict: if that is not possible any more.
        """
        with self._database.write() as connection:
            lock(connection, task.collection)
            row = connection.execute(sa.select(tasks).where(tasks.c.task_id == task.task_id)).one()
            found = record_of(Task, row)
            if found.state == OPEN:
                return found
            if found.state != EXPIRED:
                raise Conflict(f"the task is {found.state}, expected an open one")
            if open_task(connection, found.worker_id) is not None:
                raise Conflict("there is another open task; submit it or give it back first")
            if not is_free(connection, found):
                raise Conflict("the task was given to somebody else, after it had not been used for too long")
            opened = {"state": OPEN, "ended_at": None, "seen_at": self._clock()}
            connection.execute(tasks.update().where(tasks.c.task_id == task.task_id).values(**opened))
        return self.get(task.task_id)

    def expire(self, collection: Collection) -> int:
        """Return the open tasks to the pool that were not used for `task_minutes`; return their number."""
        with self._database.write() as connection:
            lock(connection, collection.name)
            return self._expire(connection, collection)

    def _expire(self, connection: Connection, collection: Collection, except_of: str = "") -> int:
        now = self._clock()
        latest = now - timedelta(minutes=collection.settings.task_minutes)
        old = (
            tasks.c.collection == collection.name,
            tasks.c.state == OPEN,
            tasks.c.seen_at <= latest,
            tasks.c.worker_id != except_of,
        )
        return connection.execute(tasks.update().where(*old).values(state=EXPIRED, ended_at=now)).rowcount

    def _claim(
        self,
        collection: Collection,
        worker: Worker,
        stage: str,
        choose: Callable[[Connection], Mapping[str, Any] | None],
        *,
        counts: bool = True,
    ) -> Task | None:
        check_active(worker)
        with self._database.write() as connection:
            lock(connection, collection.name)
            if (mine := open_task(connection, worker.worker_id)) is not None:
                if mine.stage != stage:
                    raise Conflict("there is another open task; submit it or give it back first")
                return mine
            state = sa.select(collections.c.state).where(collections.c.name == collection.name)
            if (found := connection.execute(state).scalar()) != RUNNING:
                raise Conflict(f"the collection is {found}; no tasks are given out")
            if counts:
                check_limit(connection, collection, worker, stage)
            self._expire(connection, collection)
            if (chosen := choose(connection)) is None:
                return None
            now, task_id = self._clock(), new_id()
            row: dict[str, Any] = {
                "task_id": task_id,
                "collection": collection.name,
                "stage": stage,
                "worker_id": worker.worker_id,
                "text_id": None,
                "is_gold": False,
                "state": OPEN,
                "started_at": now,
                "seen_at": now,
                "position": {},
                **chosen,
            }
            connection.execute(tasks.insert(), [row])
        return self.get(task_id)
