"""What the modules of storage share: ids, the clock, and the lock of a collection."""

import hashlib
import secrets
from collections.abc import Callable
from datetime import UTC, datetime

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.collection_tables import collections

Clock = Callable[[], datetime]
"""Returns the present time, with its time zone."""


def utc_now() -> datetime:
    """Return the present time."""
    return datetime.now(UTC)


def random_number() -> float:
    """Return an unpredictable number in [0, 1)."""
    return secrets.randbelow(1 << 53) / (1 << 53)


def new_id() -> str:
    """Return a random id of 32 hexadecimal digits."""
    return secrets.token_hex(16)


def new_secret() -> str:
    """Return a random secret of 43 characters, for links and cookies."""
    return secrets.token_urlsafe(32)


def secret_hash(secret: str) -> str:
    """Return the SHA-256 under which a secret is stored, in hexadecimal. Secrets are random and need no salt."""
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def lock(connection: Connection, name: str) -> None:
    """Lock a collection until the transaction ends, so that tasks are given out and paid one after the other.

    Raises:
        NotFound: if there is no such collection.
    """
    mine = sa.select(collections.c.name).where(collections.c.name == name).with_for_update()
    if connection.execute(mine).first() is None:
        raise NotFound(f"there is no collection {quoted(name)}")
