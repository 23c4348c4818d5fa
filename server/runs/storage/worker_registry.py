"""Registry of live worker processes on all hosts that share a database, with their addresses."""

import sqlalchemy as sa

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.host_identity import host_identity
from arramon_server.runs.storage.service_clock import tick

FORGET_SECONDS = 86_400.0
"""Time since its last heartbeat after which a killed worker is removed."""


class WorkerRegistry:
    """Registry of all workers. Thread-safe.

    Args:
        database: storage of the registry.
        host: identity of this process's host, by default `host_identity`; addresses are visible on their own host only.
    """

    def __init__(self, database: Database, *, host: str | None = None) -> None:
        self._database = database
        self._host = host_identity() if host is None else host

    def beat(self, worker: str, address: str = "") -> None:
        """Record a heartbeat of a worker, and advance the service clock.

        Args:
            worker: id of the worker.
            address: its own address on this host; empty if it has none.
        """
        table, now = tables.workers, self._database.now
        with self._database.write() as connection:
            done = connection.execute(table.update().where(table.c.worker_id == worker).values(seen=now))
            if not done.rowcount:
                row = {"worker_id": worker, "seen": now, "address": address, "host": self._host}
                connection.execute(table.insert().values(row))
                connection.execute(table.delete().where(table.c.seen < now - FORGET_SECONDS))
            tick(connection, now)

    def addresses(self, within: float) -> list[str]:
        """Return the addresses of this host's workers with a heartbeat in the last `within` seconds."""
        c = tables.workers.c
        alive = sa.func.abs(self._database.now - c.seen) <= within
        query = sa.select(c.address).where(alive, c.host == self._host, c.address != "").order_by(c.address)
        return [row.address for row in self._database.read(query)]

    def retire(self, worker: str) -> None:
        """Remove a worker that is shutting down, which frees the episodes that it still holds."""
        table = tables.workers
        with self._database.write() as connection:
            connection.execute(table.delete().where(table.c.worker_id == worker))
