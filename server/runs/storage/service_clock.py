"""The service clock of a journal: seconds during which at least one server process was running.

All processes advance it with their heartbeats, and share it. It stops while no process runs, and a jump of the wall
clock moves it by at most `LONGEST_TICK`: what it measures is never the server's own absence.
"""

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.runs.storage import tables

LONGEST_TICK = 3.0
"""Maximum seconds that count between two heartbeats, which come once a second."""


def service_time(now: sa.ColumnElement[float]) -> sa.ColumnElement[float]:
    """Return the SQL expression of the service clock's time, in seconds since an arbitrary moment.

    Args:
        now: current time by the wall clock, `Database.now`.
    """
    return sa.select(tables.service_clock.c.seconds + _since_tick(now)).scalar_subquery()


def tick(connection: Connection, now: sa.ColumnElement[float]) -> None:
    """Advance the service clock to the current time."""
    seconds = tables.service_clock.c.seconds
    connection.execute(tables.service_clock.update().values(seconds=seconds + _since_tick(now), seen=now))


def _since_tick(now: sa.ColumnElement[float]) -> sa.ColumnElement[float]:
    passed = now - tables.service_clock.c.seen
    return sa.case((passed < 0.0, 0.0), (passed > LONGEST_TICK, LONGEST_TICK), else_=passed)
