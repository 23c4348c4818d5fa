"""Participants and their tokens: creation, listing, revocation and authentication."""

import hmac
import secrets
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from arramon_server.errors import BadInput, Conflict, NotFound, Unauthenticated
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database, utc
from arramon_server.visible_text import JOINERS, STYLES, invisible_part, is_visible

PREFIX = "arramon"
"""Prefix of every token, by which scanners for leaked secrets can recognise one."""

SECRET_BYTES = 32
"""Random bytes in a token. They cannot be guessed, so a plain SHA-256 protects them as well as a slow hash protects a
password, and does not delay a call."""

LONGEST_NAME, LONGEST_NOTE = 100, 200
"""Maximum characters in a participant's name, and in the note of a token."""

ANONYMOUS_NAME = "anonymous"
"""Name of all callers without a token; no participant may have it."""

COLLECTING_NAME = "collecting"
"""Name of the account that owns the runs in which people verify collected texts; no participant may have it."""


@dataclass(frozen=True, slots=True)
class AccessToken:
    """Metadata of an access token, without its secret.

    Attributes:
        token_id: public part of the token, which identifies it.
        participant: owner of the token.
        role: role of the participant.
        note: note of the host.
        created_at, expires_at, revoked_at: times in UTC; None for never.
    """

    token_id: str
    participant: str
    role: Role
    note: str
    created_at: datetime
    expires_at: datetime | None = None
    revoked_at: datetime | None = None


class Accounts:
    """Participants of this server and their tokens. Thread-safe.

    Args:
        database: storage of the participants and tokens.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def create_token(self, participant: str, role: Role, *, days: float | None = None, note: str = "") -> str:
        """Create a token, and its participant if necessary, and return the token. Only its hash is stored.

        Args:
            participant: name of the participant.
            role: role of the participant.
            days: days until the token expires; None for never.
            note: note for the host, such as the recipient.

        Raises:
            BadInput: if an argument is out of range.
            Conflict: if the participant has another role, or the name can be confused with another participant's.
        """
        now = datetime.now(UTC)
        check_name(participant)
        if len(note) > LONGEST_NOTE:
            raise BadInput(f"the note has {len(note)} characters; at most {LONGEST_NOTE} are allowed")
        if (part := invisible_part(note)) is not None:
            raise BadInput(f"the note has {part}, expected one line of visible text")
        if days is not None and not 0 < days <= 36_500:
            raise BadInput(f"the token expires in {days:g} days, expected more than 0 and at most 36500")
        token_id, secret = secrets.token_hex(6), secrets.token_urlsafe(SECRET_BYTES)
        row = {
            "token_id": token_id,
            "participant": participant,
            "hash": _hash(secret),
            "note": note,
            "created_at": now,
            "expires_at": now + timedelta(days=days) if days is not None else None,
        }
        with self._database.write() as connection:
            self._enrol(connection, participant, role, now)
            connection.execute(tables.tokens.insert(), [row])
        return f"{PREFIX}_{token_id}_{secret}"

    def tokens(self) -> list[AccessToken]:
        """Return all tokens, oldest first."""
        return [_token(row) for row in self._database.read(_TOKENS.order_by(tables.tokens.c.created_at))]

    def revoke(self, token_id: str) -> AccessToken:
        """Revoke a token. One that was revoked before keeps its time of revocation.

        Raises:
            NotFound: if there is no token with that id.
        """
        table = tables.tokens
        with self._database.write() as connection:
            live = table.update().where(table.c.token_id == token_id, table.c.revoked_at.is_(None))
            connection.execute(live.values(revoked_at=datetime.now(UTC)))
        rows = self._database.read(_TOKENS.where(table.c.token_id == token_id))
        if not rows:
            raise NotFound(f"there is no token {token_id!r}; `arramon-server token list` shows them")
        return _token(rows[0])

    def caller(self, token: str) -> Caller:
        """Return the caller that a token authenticates.

        Raises:
            Unauthenticated: if the token is malformed, unknown, revoked or expired. The last two are reported
                only for a correct token: its owner learns what to do, and others learn nothing.
        """
        prefix, _, rest = token.partition("_")
        token_id, _, secret = rest.partition("_")
        if prefix != PREFIX or not (token_id.isalnum() and secret and token.isascii()):
            raise Unauthenticated(f"authentication failed: malformed token; expected one that begins with {PREFIX}_")
        row = find_token(self._database, token_id)
        # Compared in constant time as a precaution; a partial match of hashes would reveal nothing about a secret.
        if row is None or not hmac.compare_digest(row.hash, _hash(secret)):
            raise Unauthenticated("authentication failed: unknown token; ask the host for another one")
        return usable_caller(row)

    def is_taken(self, name: str) -> bool:
        """Return whether a name is or was a participant's name, or can be confused with one."""
        names = (tables.participants.c.participant, tables.earlier_names.c.name)
        return any(find_alike([row[0] for row in self._database.read(sa.select(each))], name) for each in names)

    def _enrol(self, connection: Connection, participant: str, role: Role, now: datetime) -> None:
        known = {row.participant: row for row in connection.execute(sa.select(tables.participants))}
        if participant not in known:
            check_name_free(connection, participant)
            row = {"participant": participant, "role": role.value, "created_at": now}
            connection.execute(tables.participants.insert(), [row])
        elif known[participant].role != role.value:
            raise Conflict(f"{participant!r} has the role {known[participant].role}; a {role.value} needs another name")
        elif known[participant].banned_at is not None:
            raise Conflict(f"{participant!r} is banned; `arramon-server account unban` ends that")


def find_token(database: Database, token_id: str) -> Row[Any] | None:
    """Return the database row of a token with its participant; None if there is none of that id."""
    rows = database.read(_TOKENS.where(tables.tokens.c.token_id == token_id))
    return rows[0] if rows else None


def usable_caller(row: Row[Any]) -> Caller:
    """Return the caller to whom a token belongs.

    Args:
        row: what `find_token` found.

    Raises:
        Unauthenticated: if the token is revoked or expired, or its participant is banned.
    """
    found = _token(row)
    if row.banned_at is not None:
        raise Unauthenticated(f"authentication failed: {ban_clause(found.participant, row.ban_reason)}")
    if found.revoked_at is not None:
        raise Unauthenticated(
            f"authentication failed: token {found.token_id} was revoked; ask the host for another one"
        )
    if found.expires_at is not None and found.expires_at <= datetime.now(UTC):
        raise Unauthenticated(
            f"authentication failed: token {found.token_id} expired on {found.expires_at:%Y-%m-%d}; "
            "ask the host for another one"
        )
    return Caller(found.role, found.participant)


def check_name(name: str) -> None:
    """Check that a participant may have a name.

    Raises:
        BadInput: if the name is too long, has invisible characters or extra spaces, or is reserved.
    """
    if not 1 <= len(name) <= LONGEST_NAME:
        raise BadInput(f"the participant's name has {len(name)} characters, expected 1 to {LONGEST_NAME}")
    if name != " ".join(name.split()) or not is_visible(name):
        raise BadInput(f"the participant's name {name!r} has invisible characters or extra spaces")
    if _normalized(name) == ANONYMOUS_NAME:
        raise BadInput(f"the name {name!r} is reserved for callers without a token; a participant needs another name")
    if _normalized(name) == COLLECTING_NAME:
        raise BadInput(f"the name {name!r} is reserved for collections of texts; a participant needs another name")


def _normalized(name: str) -> str:
    """Return a name without case, width and joiners: no two participants' names may differ in these alone."""
    return unicodedata.normalize("NFKC", name.translate(dict.fromkeys(map(ord, JOINERS + STYLES)))).casefold()


def find_alike(names: Sequence[str], name: str) -> str | None:
    """Return the first of the names that is equal to or can be confused with a name; None if there is none."""
    wanted = _normalized(name)
    return next((each for each in names if _normalized(each) == wanted), None)


def check_name_free(connection: Connection, name: str, *, except_name: str | None = None) -> None:
    """Check that a name can be given to a participant.

    Args:
        connection: connection in the transaction that gives the name.
        name: the name.
        except_name: participant whose own names, present and earlier, do not count.

    Raises:
        Conflict: if the name can be confused with another participant's, or with the earlier name of another.
    """
    participants, earlier = tables.participants.c, tables.earlier_names.c
    present = [row[0] for row in connection.execute(sa.select(participants.participant)) if row[0] != except_name]
    if (alike := find_alike(present, name)) is not None:
        raise Conflict(f"the name {name!r} can be confused with that of the participant {alike!r}")
    once = {row.name: row.participant for row in connection.execute(sa.select(earlier.name, earlier.participant))}
    if (alike := find_alike([each for each, who in once.items() if who != except_name], name)) is not None:
        raise Conflict(f"the name {name!r} can be confused with {alike!r}, an earlier name of {once[alike]!r}")


def ban_clause(participant: str, reason: str) -> str:
    """Return the clause of a message that a participant is banned, with the host's reason if there is one."""
    return f"the account {participant!r} is banned" + (f": {reason}" if reason else "") + "; ask the host"


def _hash(secret: str) -> str:
    return sha256(secret.encode()).hexdigest()


_TOKENS = sa.select(
    tables.tokens, *(tables.participants.c[name] for name in ("role", "banned_at", "ban_reason"))
).join_from(tables.tokens, tables.participants)


def _token(row: Row[Any]) -> AccessToken:
    times: Sequence[datetime | None] = [utc(row._mapping[name]) for name in ("created_at", "expires_at", "revoked_at")]
    created_at, expires_at, revoked_at = times
    assert created_at is not None
    return AccessToken(row.token_id, row.participant, Role(row.role), row.note, created_at, expires_at, revoked_at)
