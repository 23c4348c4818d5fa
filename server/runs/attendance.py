"""The worker processes that are alive, over all hosts that share a database, and where each host finds its own."""

import sqlalchemy as sa

from server.runs import tables
from server.runs.database import Database
from server.runs.here import here

FORGET_SECONDS = 86_400.0
"""After its last sign of life, in which a worker that was killed is not listed any more."""


class Attendance:
    """All workers. Safe to use from several threads.

    Args:
        database: where they are noted.
        host: which one this process is on: what a host's own addresses are told to.
    """

    def __init__(self, database: Database, *, host: str | None = None) -> None:
        self._database = database
        self._host = here() if host is None else host

    def beat(self, worker: str, address: str = "") -> None:
        """A worker is alive, and can be reached on this host at an address of its own, if it has one."""
        table, now = tables.workers, self._database.now
        with self._database.write() as connection:
            done = connection.execute(table.update().where(table.c.worker_id == worker).values(seen=now))
            if not done.rowcount:
                row = {"worker_id": worker, "seen": now, "address": address, "host": self._host}
                connection.execute(table.insert().values(row))
                connection.execute(table.delete().where(table.c.seen < now - FORGET_SECONDS))

    def addresses(self, within: float) -> list[str]:
        """The own addresses of this host's workers that were seen alive in the last `within` seconds."""
        c = tables.workers.c
        alive = sa.func.abs(self._database.now - c.seen) <= within
        query = sa.select(c.address).where(alive, c.host == self._host, c.address != "").order_by(c.address)
        return [row.address for row in self._database.read(query)]

    def retire(self, worker: str) -> None:
        """A worker is gone for good; what it still held is free."""
        table = tables.workers
        with self._database.write() as connection:
            connection.execute(table.delete().where(table.c.worker_id == worker))
