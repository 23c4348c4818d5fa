"""The host's Ed25519 key for signing receipts, created on first use and shared by all hosts of a database."""

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

from arramon_server.errors import BadFile, Conflict
from arramon_server.private_files import private_file
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database, utc

ADOPT = "arramon-server key --adopt"
"""Command with which a host changes the signing key."""

_KEYS = tables.host_keys
_IN_ORDER = sa.select(_KEYS).order_by(_KEYS.c.since, _KEYS.c.public_key)


@dataclass(frozen=True, slots=True)
class PublicKey:
    """Public key that verifies receipts.

    Attributes:
        key: Ed25519 public key, 32 bytes.
        since: time since which the host has signed with it, in UTC.
    """

    key: bytes
    since: datetime


class SigningKey:
    """Private signing key of the host.

    Args:
        path: path of the key file, PEM (PKCS #8, not encrypted) of mode 600; created if there is none.

    Attributes:
        public: public key, 32 bytes.

    Raises:
        BadFile: if others can read the file, or it contains no Ed25519 key.
        StorageError: if the file cannot be created or read.
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
        """Return the signature over the given bytes, 64 bytes."""
        return self._key.sign(content)

    def public_pem(self) -> str:
        """Return the public key as PEM (SubjectPublicKeyInfo), as openssl reads it."""
        form = serialization.PublicFormat.SubjectPublicKeyInfo
        return self._key.public_key().public_bytes(serialization.Encoding.PEM, form).decode()


class KnownKeys:
    """Public keys with which the receipts of a database were signed, over time.

    Args:
        database: database of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self) -> list[PublicKey]:
        """Return all keys, the current one last."""
        return [PublicKey(row.public_key, utc(row.since) or row.since) for row in self._database.read(_IN_ORDER)]

    def check(self, public: bytes) -> None:
        """Check that a host's key is the current key of the database; the first key ever checked becomes that key.

        Raises:
            Conflict: if the database has another key; the message says what to do.
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
                f"{known[-1].key.hex()}: copy the key file of the other host to this one, or change to this host's key "
                f"with `{ADOPT}`"
            )

    def adopt(self, public: bytes) -> bool:
        """Make a key the current key of the database; return whether that was another key before."""
        with self._locked() as connection:
            known = connection.execute(_IN_ORDER).all()
            if known and known[-1].public_key == public:
                return False
            connection.execute(_KEYS.delete().where(_KEYS.c.public_key == public))
            _insert(connection, public)
        return True

    @contextmanager
    def _locked(self) -> Iterator[Connection]:
        """Yield a connection in a transaction that keeps other processes from writing keys."""
        with self._database.write() as connection:
            if connection.dialect.name == "postgresql":  # SQLite has one writer at a time
                connection.execute(sa.text(f"LOCK TABLE {_KEYS.name} IN EXCLUSIVE MODE"))
            yield connection


def _insert(connection: Connection, public: bytes) -> None:
    connection.execute(_KEYS.insert(), [{"public_key": public, "since": datetime.now(UTC)}])


def _new_key() -> bytes:
    return Ed25519PrivateKey.generate().private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
