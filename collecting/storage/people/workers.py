"""Workers and hosts of collections: invitations, consent, screening, states."""

from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.settings import STAGES
from arramon_collecting.storage.people.records import (
    ACTIVE,
    BLOCKED,
    FORGOTTEN,
    HOST,
    INVITED,
    LEFT,
    WORKER,
    WORKER_PAUSED,
    Worker,
)
from arramon_collecting.storage.records import Collection, first_record, record_of
from arramon_collecting.storage.transactions import Clock, lock, new_id, new_secret, secret_hash, utc_now
from arramon_collecting.storage.work.records import OPEN, RETURNED
from arramon_server.errors import BadInput, Conflict, Forbidden, NotFound, quoted
from arramon_server.runs.storage.collection_tables import tasks, workers
from arramon_server.runs.storage.database import Database
from arramon_server.visible_text import is_visible

MAX_NOTE, MAX_EMAIL, MAX_EXTERNAL = 200, 320, 200
"""Maximum numbers of characters."""

MIN_BEGINNING = 4
"""Minimum number of characters of a pseudonym by which a worker is found."""

WORKER_STATES = (INVITED, ACTIVE, WORKER_PAUSED, BLOCKED, LEFT, FORGOTTEN)
"""All states of a worker."""


class Workers:
    """The workers and hosts of all collections.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def invite(
        self,
        collection: Collection,
        *,
        role: str = WORKER,
        stages: Sequence[str] = STAGES,
        note: str = "",
        email: str = "",
    ) -> tuple[Worker, str]:
        """Create a worker or host with a personal link; return it and the link's secret, which is not stored.

        Raises:
            BadInput: if the note or the mail address is malformed.
        """
        if len(note) > MAX_NOTE or not is_visible(note):
            raise BadInput(f"the note is {quoted(note)}, expected one line of at most {MAX_NOTE} characters")
        key = new_secret()
        created = self._new(collection, role, stages, link_hash=secret_hash(key), note=note, email=checked_email(email))
        return created, key

    def join(self, collection: Collection, external_id: str, stages: Sequence[str]) -> Worker:
        """Return the worker with an id of the crowd platform, who is created at the first visit, and does these stages.

        Raises:
            BadInput: if the id is malformed.
        """
        if not 1 <= len(external_id) <= MAX_EXTERNAL or not is_visible(external_id):
            raise BadInput(f"the platform's id is {quoted(external_id)}, expected 1 to {MAX_EXTERNAL} characters")
        with self._database.write() as connection:
            lock(connection, collection.name)
            query = sa.select(workers).where(
                workers.c.collection == collection.name, workers.c.external_id == external_id
            )
            if connection.execute(query).first() is None:
                return self._insert(connection, collection, WORKER, stages, external_id=external_id)
            mine = workers.c.collection == collection.name, workers.c.external_id == external_id
            connection.execute(workers.update().where(*mine).values(stages=list(stages)))
            return record_of(Worker, connection.execute(query).one())

    def add_host(self, collection: Collection, account: str) -> Worker:
        """Return the host who signs in with the token of an account, created at the first sign-in."""
        query = sa.select(workers).where(
            workers.c.collection == collection.name, workers.c.role == HOST, workers.c.note == account
        )
        with self._database.write() as connection:
            lock(connection, collection.name)
            if (row := connection.execute(query).first()) is not None:
                return record_of(Worker, row)
            return self._insert(connection, collection, HOST, (), note=account, state=ACTIVE)

    def by_link(self, collection: str, key: str) -> Worker | None:
        """Return the worker of a link's secret; None if it is none of this collection."""
        query = sa.select(workers).where(workers.c.link_hash == secret_hash(key), workers.c.collection == collection)
        return first_record(self._database, Worker, query)

    def get(self, worker_id: str) -> Worker:
        """Return a worker.

        Raises:
            NotFound: if there is none of that id.
        """
        found = first_record(self._database, Worker, sa.select(workers).where(workers.c.worker_id == worker_id))
        if found is None:
            raise NotFound(f"there is no worker {quoted(worker_id)}")
        return found

    def find(self, collection: Collection, beginning: str) -> Worker:
        """Return the worker of a collection whose pseudonym begins with a text of at least 4 characters.

        Raises:
            BadInput: if the text is shorter, or several pseudonyms begin with it.
            NotFound: if none does.
        """
        if len(beginning) < MIN_BEGINNING:
            raise BadInput(
                f"the worker is {quoted(beginning)}, expected at least {MIN_BEGINNING} characters of the pseudonym"
            )
        found = [one for one in self.all(collection.name) if one.worker_id.startswith(beginning)]
        if not found:
            raise NotFound(
                f"there is no worker {quoted(beginning)} in collection {collection.name!r}; "
                f"`collect status {collection.name} --workers` lists them"
            )
        if len(found) > 1:
            listed = ", ".join(one.worker_id for one in found)
            raise BadInput(f"{len(found)} workers begin with {quoted(beginning)}: {listed}")
        return found[0]

    def all(self, collection: str) -> list[Worker]:
        """Return the workers and hosts of a collection, oldest first."""
        query = sa.select(workers).where(workers.c.collection == collection)
        return [record_of(Worker, row) for row in self._database.read(query.order_by(workers.c.created_at))]

    def consent(self, worker: Worker, collection: Collection, *, keep_texts: bool, language: str = "en") -> None:
        """Record that a worker agreed to the collection's text, with its hash and the time.

        Args:
            worker: the worker.
            collection: the worker's collection.
            keep_texts: whether the worker's texts stay if the worker's data is deleted.
            language: language of the page on which the text was shown.

        Raises:
            Conflict: if the worker has left, or its data was deleted.
        """
        values = {
            "state": ACTIVE,
            "consented_at": self._clock(),
            "consent_hash": collection.settings.consent_shown(language).hash_with(collection.settings.licence),
            "keep_texts": keep_texts,
        }
        self._update(worker.worker_id, values, among=(INVITED, ACTIVE, LEFT))

    def record_screening(self, worker_id: str, stage: str, result: Mapping[str, Any]) -> None:
        """Store the result of a stage's screening test, which replaces an earlier one."""
        with self._database.write() as connection:
            found = _locked(connection, worker_id)
            screening = {**found.screening, stage: dict(result)}
            connection.execute(workers.update().where(workers.c.worker_id == worker_id).values(screening=screening))

    def record_placement(self, worker_id: str) -> None:
        """Record that the placement test was passed."""
        self._update(worker_id, {"placement_passed_at": self._clock()})

    def record_device(self, worker_id: str, device: Mapping[str, Any]) -> None:
        """Store what was measured of the worker's device."""
        self._update(worker_id, {"device": dict(device)})

    def set_contact(self, worker_id: str, *, email: str, page_language: str) -> None:
        """Store a worker's mail address, which may be empty, and the language of the pages.

        Raises:
            BadInput: if the address is malformed.
        """
        self._update(worker_id, {"email": checked_email(email), "page_language": page_language})

    def set_state(self, worker_id: str, state: str) -> None:
        """Pause, block or readmit a worker. The open task of a blocked one goes back to the pool.

        Raises:
            Conflict: if the worker's data was deleted.
        """
        assert state in WORKER_STATES
        self._update(worker_id, {"state": state}, among=[one for one in WORKER_STATES if one != FORGOTTEN])
        if state == BLOCKED:
            mine = tasks.c.worker_id == worker_id, tasks.c.state == OPEN
            with self._database.write() as connection:
                connection.execute(tasks.update().where(*mine).values(state=RETURNED, ended_at=self._clock()))

    def _new(self, collection: Collection, role: str, stages: Sequence[str], **values: Any) -> Worker:
        with self._database.write() as connection:
            lock(connection, collection.name)
            return self._insert(connection, collection, role, stages, **values)

    def _insert(
        self, connection: Connection, collection: Collection, role: str, stages: Sequence[str], **values: Any
    ) -> Worker:
        row = {
            "worker_id": new_id(),
            "collection": collection.name,
            "role": role,
            "stages": list(stages),
            "state": INVITED,
            "screening": {},
            "device": {},
            "note": "",
            "email": "",
            "page_language": "",
            "created_at": self._clock(),
        } | values
        connection.execute(workers.insert(), [row])
        query = sa.select(workers).where(workers.c.worker_id == row["worker_id"])
        return record_of(Worker, connection.execute(query).one())

    def _update(self, worker_id: str, values: Mapping[str, Any], among: Sequence[str] = WORKER_STATES) -> None:
        with self._database.write() as connection:
            state = _locked(connection, worker_id).state
            if state not in among:
                raise Conflict(f"the worker is {state}, expected {' or '.join(among)}")
            connection.execute(workers.update().where(workers.c.worker_id == worker_id).values(**values))


def checked_email(email: str) -> str:
    """Return a mail address without spaces around it; empty for none.

    Raises:
        BadInput: if it cannot be one.
    """
    found = email.strip()
    name, _, domain = found.rpartition("@")
    is_line = is_visible(found) and " " not in found and not set(found) & set('<>,;"')
    if found and not (name and "." in domain and is_line and found.isascii() and len(found) <= MAX_EMAIL):
        raise BadInput(f"the mail address is {quoted(found)}, expected NAME@DOMAIN")
    return found


def check_active(worker: Worker) -> None:
    """Check that a worker may take and submit tasks.

    Raises:
        Forbidden: if not, with the reason.
    """
    if worker.state != ACTIVE:
        raise Forbidden(f"the worker is {worker.state}")


def _locked(connection: Connection, worker_id: str) -> Worker:
    row = connection.execute(sa.select(workers).where(workers.c.worker_id == worker_id).with_for_update()).first()
    if row is None:
        raise NotFound(f"there is no worker {quoted(worker_id)}")
    return record_of(Worker, row)
