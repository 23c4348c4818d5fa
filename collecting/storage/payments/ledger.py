"""The ledger: what a collection owes to whom, and for what. Nothing is paid twice, as each subject has one entry."""

from collections.abc import Iterable
from datetime import datetime

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.rules.payment import Payment
from arramon_collecting.settings import Settings
from arramon_collecting.storage.payments.records import PAID_WRITE, LedgerEntry
from arramon_collecting.storage.records import record_of
from arramon_collecting.storage.transactions import new_id
from arramon_server.runs.storage.collection_tables import ledger
from arramon_server.runs.storage.database import Database


class Ledger:
    """The ledger of all collections.

    Args:
        database: the journal's database.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def entries(self, collection: str) -> list[LedgerEntry]:
        """Return the entries of a collection, oldest first."""
        query = sa.select(ledger).where(ledger.c.collection == collection)
        return [record_of(LedgerEntry, row) for row in self._database.read(query.order_by(*_ORDER))]

    def entries_of(self, worker_id: str) -> list[LedgerEntry]:
        """Return the entries of a worker, oldest first."""
        query = sa.select(ledger).where(ledger.c.worker_id == worker_id)
        return [record_of(LedgerEntry, row) for row in self._database.read(query.order_by(*_ORDER))]

    def total(self, collection: str) -> int:
        """Return the sum of a collection's entries, in the currency's smallest unit."""
        query = sa.select(sa.func.coalesce(sa.func.sum(ledger.c.amount_minor), 0))
        return int(self._database.read(query.where(ledger.c.collection == collection))[0][0])

    def total_of(self, worker_id: str) -> int:
        """Return the sum of a worker's entries, in the currency's smallest unit."""
        query = sa.select(sa.func.coalesce(sa.func.sum(ledger.c.amount_minor), 0))
        return int(self._database.read(query.where(ledger.c.worker_id == worker_id))[0][0])


def pay(
    connection: Connection,
    collection: str,
    worker_id: str,
    payments: Iterable[Payment],
    settings: Settings,
    now: datetime,
) -> list[Payment]:
    """Add entries in the transaction of what they pay for; return those that were not there yet.

    The collection must be locked.
    """
    added = []
    for payment in payments:
        c = ledger.c
        key = (
            c.collection == collection,
            c.worker_id == worker_id,
            c.kind == payment.kind,
            c.subject == payment.subject,
        )
        if connection.execute(sa.select(c.entry_id).where(*key)).first() is not None:
            continue
        row = {
            "entry_id": new_id(),
            "collection": collection,
            "worker_id": worker_id,
            "kind": payment.kind,
            "subject": payment.subject,
            "amount_minor": payment.amount_minor,
            "currency": settings.currency,
            "created_at": now,
        }
        connection.execute(ledger.insert(), [row])
        added.append(payment)
    return added


def accepted_texts(connection: Connection, worker_id: str) -> int:
    """Return the number of a worker's texts that were accepted."""
    query = sa.select(sa.func.count()).where(ledger.c.worker_id == worker_id, ledger.c.kind == PAID_WRITE)
    return connection.execute(query).scalar() or 0


_ORDER = (ledger.c.created_at, ledger.c.entry_id)
