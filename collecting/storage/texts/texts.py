"""Texts: reading them. Submissions and reviews, which change them and pay, are in `submissions` and `reviews`."""

from collections import Counter
from collections.abc import Iterable
from datetime import datetime

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.storage.records import Collection, first_record, record_of
from arramon_collecting.storage.texts.records import IN_REVIEW, Instructions, Text
from arramon_collecting.storage.transactions import new_id
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.collection_tables import texts
from arramon_server.runs.storage.database import Database


class Texts:
    """Texts of all collections.

    Args:
        database: the journal's database.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def get(self, text_id: str) -> Text:
        """Return a text.

        Raises:
            NotFound: if there is none of that id.
        """
        found = first_record(self._database, Text, sa.select(texts).where(texts.c.text_id == text_id))
        if found is None:
            raise NotFound(f"there is no text {quoted(text_id)}")
        return found

    def all(self, collection: str, *states: str) -> list[Text]:
        """Return the texts of a collection in these states, or all, oldest first."""
        query = sa.select(texts).where(texts.c.collection == collection)
        if states:
            query = query.where(texts.c.state.in_(states))
        return [
            record_of(Text, row) for row in self._database.read(query.order_by(texts.c.created_at, texts.c.text_id))
        ]

    def all_of(self, worker_id: str) -> list[Text]:
        """Return the texts of an author, oldest first."""
        query = sa.select(texts).where(texts.c.worker_id == worker_id).order_by(texts.c.created_at)
        return [record_of(Text, row) for row in self._database.read(query)]

    def counts(self, collection: str) -> Counter[str]:
        """Return the number of texts in each state."""
        query = sa.select(texts.c.state, sa.func.count().label("number")).where(texts.c.collection == collection)
        rows = self._database.read(query.group_by(texts.c.state))
        return Counter({row.state: row.number for row in rows})


def insert_imported(
    connection: Connection, collection: Collection, instructions: Iterable[tuple[str, Instructions]], now: datetime
) -> None:
    """Insert existing texts for a review.

    Args:
        connection: of the transaction that creates the collection.
        collection: of the kind "review".
        instructions: ids of episodes, and the texts of both turns.
        now: the time.
    """
    rows = [
        {
            "text_id": new_id(),
            "collection": collection.name,
            "episode_id": episode_id,
            "language": collection.language,
            "instructions": [list(pair) for pair in pairs],
            "failures": [],
            "evidence": {},
            "state": IN_REVIEW,
            "version": 1,
            "history": [],
            "created_at": now,
        }
        for episode_id, pairs in instructions
    ]
    if rows:
        connection.execute(texts.insert(), rows)
