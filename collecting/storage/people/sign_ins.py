"""Sign-ins of browsers: cookies, which are stored as hashes and renewed, and the values against forged requests."""

from datetime import timedelta

import sqlalchemy as sa

from arramon_collecting.storage.people.records import ACTIVE, FORGOTTEN, HOST, INVITED, SignIn
from arramon_collecting.storage.records import first_record, record_of
from arramon_collecting.storage.transactions import Clock, new_secret, secret_hash, utc_now
from arramon_server.runs.storage.collection_tables import sign_ins, workers
from arramon_server.runs.storage.database import Database

LIFETIME = timedelta(days=30)
"""Time after the last renewal for which a sign-in lasts."""

RENEWAL = timedelta(hours=1)
"""Age of a cookie from which the next request gets a new one."""

GRACE = timedelta(minutes=2)
"""Time for which the old cookie stays valid, for requests under way and other tabs."""


class SignIns:
    """Sign-ins of all collections.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def open(self, worker_id: str) -> str:
        """Sign a worker in; return the cookie. An invited host is active from then on; a worker agrees first."""
        cookie, now = new_secret(), self._clock()
        row = {
            "cookie_hash": secret_hash(cookie),
            "worker_id": worker_id,
            "csrf": new_secret(),
            "created_at": now,
            "renewed_at": now,
            "expires_at": now + LIFETIME,
        }
        with self._database.write() as connection:
            connection.execute(sign_ins.delete().where(sign_ins.c.expires_at <= now))
            connection.execute(sign_ins.insert(), [row])
            invited = workers.c.worker_id == worker_id, workers.c.role == HOST, workers.c.state == INVITED
            connection.execute(workers.update().where(*invited).values(state=ACTIVE))
        return cookie

    def find(self, collection: str, cookie: str) -> SignIn | None:
        """Return the sign-in of a cookie; None if it is unknown, expired, or of another collection."""
        query = (
            sa.select(sign_ins)
            .join(workers, workers.c.worker_id == sign_ins.c.worker_id)
            .where(
                sign_ins.c.cookie_hash == secret_hash(cookie),
                sign_ins.c.expires_at > self._clock(),
                workers.c.collection == collection,
                workers.c.state != FORGOTTEN,
            )
        )
        return first_record(self._database, SignIn, query)

    def renew(self, cookie: str) -> str | None:
        """Return a new cookie of the same sign-in if the cookie is old; None if it is still good.

        The value against forged requests stays the same, so that open pages can go on.
        """
        now, old = self._clock(), sign_ins.c.cookie_hash == secret_hash(cookie)
        with self._database.write() as connection:
            row = connection.execute(sa.select(sign_ins).where(old).with_for_update()).first()
            if row is None:
                return None
            found = record_of(SignIn, row)
            # A cookie in its grace time was renewed by another request already.
            if now < found.renewed_at + RENEWAL or found.expires_at <= now + GRACE:
                return None
            renewed = new_secret()
            connection.execute(sign_ins.update().where(old).values(expires_at=now + GRACE))
            values = row._asdict() | {
                "cookie_hash": secret_hash(renewed),
                "renewed_at": now,
                "expires_at": now + LIFETIME,
            }
            connection.execute(sign_ins.insert(), [values])
        return renewed

    def close(self, worker_id: str) -> None:
        """Sign a worker out of all browsers."""
        with self._database.write() as connection:
            connection.execute(sign_ins.delete().where(sign_ins.c.worker_id == worker_id))
