"""Queries about tasks within the transaction that gives one out or takes one in."""

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.rules.assignment import Candidate, Known
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection, record_of
from arramon_collecting.storage.texts.records import PRESENT, SENT_BACK, VERIFYING
from arramon_collecting.storage.work.records import OPEN, SUBMITTED, VERIFY, WRITE, Task
from arramon_server.errors import OverQuota
from arramon_server.runs.storage.collection_tables import tasks, texts, verifications


def known_episodes(connection: Connection, worker_id: str) -> Known:
    """Return the episodes that a worker knows: those of all tasks, also of those given back or expired."""
    c = tasks.c
    query = sa.select(c.stage, c.episode_id).where(c.worker_id == worker_id)
    rows = connection.execute(query.distinct()).all()
    return Known(
        frozenset(row.episode_id for row in rows if row.stage == WRITE),
        frozenset(row.episode_id for row in rows if row.stage == VERIFY),
    )


def taken_episodes(connection: Connection, collection: str) -> set[str]:
    """Return the episodes that have a text, or are being written for."""
    present = sa.select(texts.c.episode_id).where(texts.c.collection == collection, texts.c.state.in_(PRESENT))
    being_written = sa.select(tasks.c.episode_id).where(
        tasks.c.collection == collection, tasks.c.stage == WRITE, tasks.c.state == OPEN
    )
    return {row.episode_id for query in (present, being_written) for row in connection.execute(query)}


def waiting_texts(connection: Connection, collection: Collection) -> list[Candidate]:
    """Return the texts that wait for verifiers, oldest first."""
    waiting = sa.select(texts).where(texts.c.collection == collection.name, texts.c.state == VERIFYING)
    rows = connection.execute(waiting.order_by(texts.c.created_at, texts.c.text_id)).all()
    done = sa.select(verifications.c.text_id, verifications.c.worker_id).where(
        verifications.c.collection == collection.name, verifications.c.counts
    )
    under_way = sa.select(tasks.c.text_id, tasks.c.worker_id).where(
        tasks.c.collection == collection.name, tasks.c.stage == VERIFY, tasks.c.state == OPEN
    )
    verifiers: dict[str, set[str]] = {}
    for query in (done, under_way):
        for row in connection.execute(query):
            verifiers.setdefault(row.text_id, set()).add(row.worker_id)
    return [
        Candidate(row.text_id, row.episode_id, row.worker_id, frozenset(verifiers.get(row.text_id, ()))) for row in rows
    ]


def verifications_begun(connection: Connection, worker_id: str) -> tuple[int, int]:
    """Return the numbers of verifications that a worker has begun, and of golds among them."""
    query = sa.select(tasks.c.is_gold).where(tasks.c.worker_id == worker_id, tasks.c.stage == VERIFY)
    found = [row.is_gold for row in connection.execute(query)]
    return len(found), sum(found)


def open_task(connection: Connection, worker_id: str) -> Task | None:
    """Return a worker's open task; None if there is none."""
    query = sa.select(tasks).where(tasks.c.worker_id == worker_id, tasks.c.state == OPEN)
    row = connection.execute(query).first()
    return record_of(Task, row) if row is not None else None


def check_limit(connection: Connection, collection: Collection, worker: Worker, stage: str) -> None:
    """Check that a worker may do a further task of a stage.

    Raises:
        OverQuota: if not.
    """
    most = collection.settings.max_tasks
    query = sa.select(sa.func.count()).where(
        tasks.c.worker_id == worker.worker_id, tasks.c.stage == stage, tasks.c.state == SUBMITTED
    )
    if most and (connection.execute(query).scalar() or 0) >= most:
        raise OverQuota(f"you have done {most} tasks of this kind, which is the most that one person may do here")


def is_free(connection: Connection, task: Task) -> bool:
    """Return whether an expired task is still to be done: nobody else has taken its place."""
    if task.stage == WRITE and task.text_id is None:
        return task.episode_id not in taken_episodes(connection, task.collection)
    if task.text_id is None:
        return True  # a gold
    state = connection.execute(sa.select(texts.c.state).where(texts.c.text_id == task.text_id)).scalar()
    return state == (SENT_BACK if task.stage == WRITE else VERIFYING)
