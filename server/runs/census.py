"""How many runs there are, over all processes."""

import sqlalchemy as sa

from server.errors import StorageError
from server.runs import tables
from server.runs.database import Database


def runs_by_state(database: Database) -> dict[str, int]:
    """The number of runs in each state; empty where the database does not answer."""
    table = tables.runs
    try:
        rows = database.read(sa.select(table.c.state, sa.func.count().label("number")).group_by(table.c.state))
    except StorageError:  # readiness says so, and the metrics then tell the rest
        return {}
    return {row.state: row.number for row in rows}
