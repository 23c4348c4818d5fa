"""Drafts of tasks, which survive a reload and a new device, and never overwrite a newer one."""

from collections.abc import Mapping
from datetime import datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.storage.records import first_record, record_of
from arramon_collecting.storage.transactions import Clock, utc_now
from arramon_collecting.storage.work.records import OPEN, Draft, Task
from arramon_server.errors import BadInput, Conflict
from arramon_server.runs.storage.collection_tables import drafts, tasks
from arramon_server.runs.storage.database import Database

IDLE_SECONDS = 60.0
"""Longest pause between two signs of activity that counts as active time."""

MAX_DRAFT_BYTES = 256 << 10
"""Maximum size of a draft as JSON."""


class OlderDraft(Conflict):
    """The draft is based on an older revision than the saved one.

    Args:
        newer: the saved draft.
    """

    def __init__(self, newer: Draft, based_on: int) -> None:
        super().__init__(f"the draft is based on revision {based_on}, but {newer.revision} was saved meanwhile")
        self.newer = newer


class Drafts:
    """Drafts of all tasks.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def get(self, task_id: str) -> Draft:
        """Return a task's draft; one of revision 0, which is empty, if none was saved."""
        found = first_record(self._database, Draft, sa.select(drafts).where(drafts.c.task_id == task_id))
        return found or Draft(task_id, 0, {}, None)

    def save(self, task: Task, based_on: int, body: Mapping[str, Any], *, size: int) -> Draft:
        """Save a draft, and keep the task from expiring; return the draft with its new revision.

        Args:
            task: an open task.
            based_on: revision that the page had when its user changed it; 0 for none.
            body: the draft.
            size: its size as JSON, in bytes.

        Raises:
            OlderDraft: if a newer one was saved meanwhile; it has the newer one.
            Conflict: if the task is not open any more.
            BadInput: if it is too large.
        """
        if size > MAX_DRAFT_BYTES:
            raise BadInput(f"the draft has {size} bytes; at most {MAX_DRAFT_BYTES} are allowed")
        now = self._clock()
        with self._database.write() as connection:
            open_task = check_open(connection, task.task_id)
            row = connection.execute(sa.select(drafts).where(drafts.c.task_id == task.task_id)).first()
            found = record_of(Draft, row) if row is not None else Draft(task.task_id, 0, {}, None)
            if found.revision != based_on:
                if found.body == body:  # The answer to an earlier save was lost.
                    return found
                raise OlderDraft(found, based_on)
            saved = Draft(task.task_id, based_on + 1, dict(body), now)
            values = {"revision": saved.revision, "body": saved.body, "saved_at": now}
            if row is None:
                connection.execute(drafts.insert(), [{"task_id": task.task_id} | values])
            else:
                connection.execute(drafts.update().where(drafts.c.task_id == task.task_id).values(**values))
            used = {"seen_at": now, "active_seconds": active_seconds(open_task, now)}
            connection.execute(tasks.update().where(tasks.c.task_id == task.task_id).values(**used))
        return saved


def check_open(connection: Connection, task_id: str) -> Task:
    """Lock a task and return it.

    Raises:
        Conflict: if it is not open.
    """
    row = connection.execute(sa.select(tasks).where(tasks.c.task_id == task_id).with_for_update()).one()
    found = record_of(Task, row)
    if found.state != OPEN:
        raise Conflict(f"the task is {found.state}, expected an open one")
    return found


def active_seconds(task: Task, now: datetime) -> float:
    """Return the active time of a task that is used now: longer pauses count as `IDLE_SECONDS`."""
    return task.active_seconds + min(max((now - task.seen_at).total_seconds(), 0.0), IDLE_SECONDS)
