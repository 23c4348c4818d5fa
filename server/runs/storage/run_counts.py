"""Counts of runs in the database, over all processes."""

import sqlalchemy as sa

from arramon_server.errors import StorageError
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database


def runs_by_state(database: Database) -> dict[str, int]:
    """Return the number of runs in each state; empty if the database cannot be read."""
    table = tables.runs
    try:
        rows = database.read(sa.select(table.c.state, sa.func.count().label("number")).group_by(table.c.state))
    except StorageError:  # readiness reports this; the other metrics stay available
        return {}
    return {row.state: row.number for row in rows}
