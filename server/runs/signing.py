"""The host's key, which signs receipts: Ed25519, made on first use, the same on every host of one database."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import sqlalchemy as sa
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from sqlalchemy.engine import Connection

from server.errors import BadFile, Conflict
from server.private import private_file
from server.runs import tables
from server.runs.database import Database, utc

ADOPT = "arramon-server key --adopt"
"""The command with which a host takes another key."""

_KEYS = tables.host_keys
_IN_ORDER = sa.select(_KEYS).order_by(_KEYS.c.since, _KEYS.c.public_key)


@dataclass(frozen=True, slots=True)
class PublicKey:
    """A key that receipts can be checked with.

    Attributes:
        key: 32 bytes.
        since: from when on the host signs with it, in UTC.
    """

    key: bytes
    since: datetime


class SigningKey:
    """The host's key.

    Args:
        path: the file, PEM (PKCS #8, not encrypted), of mode 600; made if there is none yet.

    Attributes:
        public: the public key, 32 bytes.

    Raises:
        BadFile: if the file can be read by others, or holds no Ed25519 key.
        StorageError: if it cannot be made or read.
    """

    def __init__(self, path: Path) -> None:
        content = private_file(path, _new_key)
        try:
            key = serialization.load_pem_private_key(content, password=None)
        except (ValueError, TypeError, UnsupportedAlgorithm):
            key = None
        if not isinstance(key, Ed25519PrivateKey):
            raise BadFile(path, "is not a signing key: expected an Ed25519 key in PEM, not encrypted")
        self._key = key
        self.public = key.public_key().public_bytes_raw()

    def sign(self, content: bytes) -> bytes:
        """The signature over these very bytes, 64 bytes."""
        return self._key.sign(content)

    def public_pem(self) -> str:
        """The public key as PEM, as openssl reads it."""
        form = serialization.PublicFormat.SubjectPublicKeyInfo
        return self._key.public_key().public_bytes(serialization.Encoding.PEM, form).decode()


class KnownKeys:
    """The keys that a database's receipts were signed with, one after the other.

    Args:
        database: of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self) -> list[PublicKey]:
        """Every key, the present one last."""
        return [PublicKey(row.public_key, utc(row.since) or row.since) for row in self._database.read(_IN_ORDER)]

    def check(self, public: bytes) -> None:
        """Makes sure that a host signs with the database's key; the first one that comes sets it.

        Raises:
            Conflict: if it is another; the message says what to do.
        """
        known = self.all()
        if not known:
            with self._locked() as connection:
                if not connection.execute(_IN_ORDER).all():
                    _insert(connection, public)
            known = self.all()
        if known[-1].key != public:
            raise Conflict(
                f"this host's signing key is {public.hex()}, but the receipts of this journal are signed with "
                f"{known[-1].key.hex()}: give this host the other's key file, or sign with this host's key from now on "
                f"by `{ADOPT}`"
            )

    def adopt(self, public: bytes) -> bool:
        """Makes a key the database's from now on; returns whether it was another before."""
        with self._locked() as connection:
            known = connection.execute(_IN_ORDER).all()
            if known and known[-1].public_key == public:
                return False
            connection.execute(_KEYS.delete().where(_KEYS.c.public_key == public))
            _insert(connection, public)
        return True

    @contextmanager
    def _locked(self) -> Iterator[Connection]:
        """A connection to write through while nobody else writes keys."""
        with self._database.write() as connection:
            if connection.dialect.name == "postgresql":  # SQLite has one writer at a time in any case
                connection.execute(sa.text(f"LOCK TABLE {_KEYS.name} IN EXCLUSIVE MODE"))
            yield connection


def _insert(connection: Connection, public: bytes) -> None:
    connection.execute(_KEYS.insert(), [{"public_key": public, "since": datetime.now(UTC)}])


def _new_key() -> bytes:
    return Ed25519PrivateKey.generate().private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
