"""The queue of mails to workers, in the database, so that it survives a restart."""

from dataclasses import dataclass
from datetime import datetime, timedelta

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import FAILED, QUEUED, SENDING, SENT, Collection, Mail, record_of
from arramon_collecting.storage.transactions import Clock, new_id, utc_now
from arramon_server.runs.storage.collection_tables import mail
from arramon_server.runs.storage.database import Database

MAX_ATTEMPTS = 12
"""Attempts after which a mail has failed: after about a day and a half, as the pauses grow to MAX_PAUSE."""

FIRST_PAUSE, MAX_PAUSE = timedelta(minutes=1), timedelta(hours=6)
"""Pause after the first failed attempt, which doubles, and the longest one."""

SENDING_TIME = timedelta(minutes=5)
"""Time after which another process takes over a mail that is being sent: the one that did has ended."""


@dataclass(frozen=True, slots=True)
class Letter:
    """The content of a mail."""

    subject: str
    body: str


def enqueue(connection: Connection, collection: Collection, worker: Worker, letter: Letter, now: datetime) -> bool:
    """Queue a mail in the transaction of what it is about; return False if no mail is sent to this worker."""
    if not (collection.settings.smtp.host and worker.email):
        return False
    row = {
        "mail_id": new_id(),
        "collection": collection.name,
        "worker_id": worker.worker_id,
        "recipient": worker.email,
        "subject": letter.subject,
        "body": letter.body,
        "state": QUEUED,
        "attempts": 0,
        "next_at": now,
        "created_at": now,
    }
    connection.execute(mail.insert(), [row])
    return True


class MailQueue:
    """The queue of all collections.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def take(self) -> Mail | None:
        """Return the next mail that is due, which no other process takes for `SENDING_TIME`; None if none is."""
        now = self._clock()
        due = sa.select(mail).where(mail.c.state.in_((QUEUED, SENDING)), mail.c.next_at <= now)
        if not self._database.read(due.limit(1)):  # without a lock: mostly there is none
            return None
        with self._database.write() as connection:
            row = connection.execute(due.order_by(mail.c.next_at).limit(1).with_for_update(skip_locked=True)).first()
            if row is None:
                return None
            found = record_of(Mail, row)
            taken = {"state": SENDING, "attempts": found.attempts + 1, "next_at": now + SENDING_TIME}
            connection.execute(mail.update().where(mail.c.mail_id == found.mail_id).values(**taken))
            return record_of(Mail, connection.execute(sa.select(mail).where(mail.c.mail_id == found.mail_id)).one())

    def mark_sent(self, sent: Mail) -> None:
        """Record that a mail was sent. Its address and text are deleted."""
        self._update(sent, {"state": SENT, "recipient": "", "body": "", "problem": ""})

    def mark_failed(self, tried: Mail, problem: str, *, for_good: bool = False) -> None:
        """Record that an attempt failed; a later one follows, unless it failed for good or too often."""
        is_last = for_good or tried.attempts >= MAX_ATTEMPTS
        pause = min(FIRST_PAUSE * 2 ** (tried.attempts - 1), MAX_PAUSE)
        values = {"state": FAILED if is_last else QUEUED, "problem": problem[:500], "next_at": self._clock() + pause}
        self._update(tried, values)

    def all(self, collection: str) -> list[Mail]:
        """Return the mails of a collection, oldest first."""
        query = sa.select(mail).where(mail.c.collection == collection).order_by(mail.c.created_at)
        return [record_of(Mail, row) for row in self._database.read(query)]

    def _update(self, one: Mail, values: dict[str, object]) -> None:
        with self._database.write() as connection:
            connection.execute(mail.update().where(mail.c.mail_id == one.mail_id).values(**values))
