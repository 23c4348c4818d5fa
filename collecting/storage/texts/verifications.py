"""Verifications: reading them. `submissions` writes them."""

import sqlalchemy as sa

from arramon_collecting.storage.records import first_record, record_of
from arramon_collecting.storage.texts.records import Verification
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.collection_tables import verifications
from arramon_server.runs.storage.database import Database


class Verifications:
    """Verifications of all collections.

    Args:
        database: the journal's database.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def get(self, task_id: str) -> Verification:
        """Return the verification that was submitted in a task.

        Raises:
            NotFound: if there is none.
        """
        found = first_record(
            self._database, Verification, sa.select(verifications).where(verifications.c.task_id == task_id)
        )
        if found is None:
            raise NotFound(f"there is no verification of the task {quoted(task_id)}")
        return found

    def of_text(self, text_id: str) -> list[Verification]:
        """Return the verifications of a text, oldest first, also those that do not count."""
        return self._where(verifications.c.text_id == text_id)

    def of_worker(self, worker_id: str) -> list[Verification]:
        """Return the verifications of a worker, oldest first, golds included."""
        return self._where(verifications.c.worker_id == worker_id)

    def all(self, collection: str) -> list[Verification]:
        """Return the verifications of a collection, oldest first, golds included."""
        return self._where(verifications.c.collection == collection)

    def _where(self, condition: sa.ColumnElement[bool]) -> list[Verification]:
        query = sa.select(verifications).where(condition).order_by(verifications.c.created_at, verifications.c.task_id)
        return [record_of(Verification, row) for row in self._database.read(query)]
