"""The collections themselves."""

import re
from collections.abc import Iterable
from dataclasses import replace

import sqlalchemy as sa
from sqlalchemy.engine import Row

from arramon_collecting.settings import Settings, read_settings
from arramon_collecting.storage.people.records import INVITED
from arramon_collecting.storage.records import CLOSED, PAUSED, RUNNING, Collection, record_of
from arramon_collecting.storage.texts.records import Instructions
from arramon_collecting.storage.texts.texts import insert_imported
from arramon_collecting.storage.transactions import Clock, lock, utc_now
from arramon_server.errors import BadInput, Conflict, NotFound, TakenOver, quoted
from arramon_server.runs.storage.collection_tables import collections, sign_ins, texts, workers
from arramon_server.runs.storage.database import Database

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,49}")


class Collections:
    """The collections of a host.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def create(
        self,
        name: str,
        kind: str,
        language: str,
        split: str,
        settings: Settings,
        imported: Iterable[tuple[str, Instructions]] = (),
    ) -> Collection:
        """Create a collection, which runs at once.

        Args:
            name: its name, which is the part of its addresses.
            kind: WRITE_KIND or REVIEW_KIND.
            language: code of the language.
            split: name of the split.
            settings: its settings.
            imported: ids of episodes and existing texts that are reviewed, added in the same transaction.

        Raises:
            BadInput: if the name is malformed.
            Conflict: if there is one of that name.
        """
        if not _NAME.fullmatch(name):
            raise BadInput(
                f"the collection's name is {quoted(name)}, expected 1 to 50 of the characters a-z, 0-9, _ and -, "
                "beginning with a letter or digit"
            )
        created = Collection(
            name, kind, language, split, settings, settings.consent, settings.consent_hash, RUNNING, self._clock()
        )
        values = {key: getattr(created, key) for key in collections.c.keys() if key != "settings"}  # noqa: SIM118
        try:
            with self._database.write() as connection:
                connection.execute(collections.insert(), [values | {"settings": settings.model_dump(mode="json")}])
                insert_imported(connection, created, imported, created.created_at)
        except TakenOver:
            there = self.get(name)
            raise Conflict(
                f"there is a collection {name!r} already: {there.kind}, {there.language}, split {there.split}, "
                f"{there.state}. Its settings are fixed; another language or other settings need another name, and "
                f"`collect delete {name}` deletes it as long as nobody has signed in"
            ) from None
        return created

    def get(self, name: str) -> Collection:
        """Return a collection.

        Raises:
            NotFound: if there is none of that name.
        """
        found = self._database.read(sa.select(collections).where(collections.c.name == name))
        if not found:
            raise NotFound(f"there is no collection {quoted(name)}")
        return _collection(found[0])

    def all(self) -> list[Collection]:
        """Return all collections, by name."""
        return list(map(_collection, self._database.read(sa.select(collections).order_by(collections.c.name))))

    def delete(self, name: str) -> None:
        """Delete a collection with its links, as long as nobody has signed in.

        Raises:
            NotFound: if there is none of that name.
            Conflict: if somebody has signed in: then there may be work and amounts that are owed.
        """
        self.get(name)
        with self._database.erase() as connection:
            lock(connection, name)
            mine = workers.c.collection == name
            people = sa.select(workers.c.worker_id).where(mine)
            signed_in = sa.select(sign_ins.c.worker_id).where(sign_ins.c.worker_id.in_(people))
            came = sa.select(workers.c.worker_id).where(
                mine, sa.or_(workers.c.state != INVITED, workers.c.consented_at.is_not(None))
            )
            if any(connection.execute(query.limit(1)).first() is not None for query in (signed_in, came)):
                raise Conflict(f"somebody has signed in to collection {name!r}; close it with `collect close {name}`")
            connection.execute(texts.delete().where(texts.c.collection == name))
            connection.execute(workers.delete().where(mine))
            connection.execute(collections.delete().where(collections.c.name == name))

    def set_state(self, name: str, state: str) -> Collection:
        """Pause, resume or close a collection. Paused and closed ones give out no tasks; open ones can be submitted.

        Raises:
            NotFound: if there is none of that name.
        """
        assert state in (RUNNING, PAUSED, CLOSED)
        with self._database.write() as connection:
            lock(connection, name)
            connection.execute(collections.update().where(collections.c.name == name).values(state=state))
        return replace(self.get(name), state=state)


def _collection(row: Row[tuple[object, ...]]) -> Collection:
    raw = record_of(Collection, row)
    return replace(raw, settings=read_settings(row._mapping["settings"], f"collection {raw.name}"))
