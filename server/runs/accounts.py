"""Participants and their tokens: made, listed, revoked, and recognised."""

import hmac
import re
import secrets
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from server.errors import BadInput, Conflict, NotFound, Unauthenticated
from server.runs import tables
from server.runs.callers import Caller, Role
from server.runs.database import Database, utc

PREFIX = "arramon"
"""How every token begins, so that a program that looks for leaked secrets can know one."""

SECRET_BYTES = 32
"""Of chance in a token. Nobody can guess so many, so that a plain SHA-256 guards them as well as a slow hash guards a
password, and a call is not held up by it."""

LONGEST_NAME, LONGEST_NOTE = 100, 200
"""Characters in a participant's name, and in what is noted of a token."""

NOBODY = "anonymous"
"""What those without a token are called; no participant can be."""

_JOINERS = "\u200c\u200d"
"""Devanagari is written with these; they show nothing by themselves."""

_STYLES = "\ufe0e\ufe0f"
"""Whether an emoji is shown in colour; nothing otherwise."""

_BLANK = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0d\uffa0\U000e0100-\U000e01ef]")
"""What Python calls printable, and yet shows nothing: fillers and selectors of variants."""

_MOST_MARKS = 4
"""On one letter. Those who stack more paint over the lines of others; no language needs so many."""


@dataclass(frozen=True, slots=True)
class Token:
    """What is known of a token; never the token itself.

    Attributes:
        token_id: public; part of the token, so that its owner and the host can name it.
        created_at, expires_at, revoked_at: in UTC; None for never.
    """

    token_id: str
    participant: str
    role: Role
    note: str
    created_at: datetime
    expires_at: datetime | None = None
    revoked_at: datetime | None = None


class Accounts:
    """The participants of this server. Safe to use from several threads.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def create_token(self, participant: str, role: Role, *, days: float | None = None, note: str = "") -> str:
        """Makes a token, and its participant where there is none yet. Returned this once: only its hash is kept.

        Args:
            participant: the name.
            role: of the participant.
            days: after which it expires; None for never.
            note: for the host, such as whom it was sent to.

        Raises:
            BadInput: if something in that is out of range.
            Conflict: if the participant has another role, or a name that can be taken for this one.
        """
        now = datetime.now(UTC)
        check_name(participant)
        if len(note) > LONGEST_NOTE:
            raise BadInput(f"the note has {len(note)} characters; at most {LONGEST_NOTE} are allowed")
        if days is not None and not 0 < days <= 36_500:
            raise BadInput(f"the token is to expire in {days:g} days, expected more than 0 and at most 36500")
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

    def tokens(self) -> list[Token]:
        """All tokens, the oldest first."""
        return [_token(row) for row in self._database.read(_TOKENS.order_by(tables.tokens.c.created_at))]

    def revoke(self, token_id: str) -> Token:
        """Makes a token good for nothing. One that was revoked before stays as it is.

        Raises:
            NotFound: if there is none of that id.
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
        """Whose a token is.

        Raises:
            Unauthenticated: if it is not good. That a token was revoked or has expired is said to those alone who have
                all of it: they know that it was one, and to their owner it says what to do.
        """
        prefix, _, rest = token.partition("_")
        token_id, _, secret = rest.partition("_")
        if prefix != PREFIX or not (token_id.isalnum() and secret and token.isascii()):
            raise Unauthenticated(f"this is no token of this server: one begins with {PREFIX}_")
        rows = self._database.read(_TOKENS.where(tables.tokens.c.token_id == token_id))
        # Compared in constant time, though only hashes are: how far one agrees would say nothing of a secret.
        if not rows or not hmac.compare_digest(rows[0].hash, _hash(secret)):
            raise Unauthenticated("the token is not known here; ask the host for another one")
        found = _token(rows[0])
        if found.revoked_at is not None:
            raise Unauthenticated(f"token {token_id} was revoked; ask the host for another one")
        if found.expires_at is not None and found.expires_at <= datetime.now(UTC):
            raise Unauthenticated(f"token {token_id} expired on {found.expires_at:%Y-%m-%d}; ask the host for another")
        return Caller(found.role, found.participant)

    def is_name_of_another(self, name: str) -> bool:
        """Whether a name is, or can be taken for, a participant's."""
        return _alike(self._database.read(sa.select(tables.participants)), name) is not None

    def _enrol(self, connection: Connection, participant: str, role: Role, now: datetime) -> None:
        known = _alike(connection.execute(sa.select(tables.participants)).all(), participant)
        if known is None:
            row = {"participant": participant, "role": role.value, "created_at": now}
            connection.execute(tables.participants.insert(), [row])
        elif known.participant != participant:
            raise Conflict(f"there is a participant {known.participant!r}, whom {participant!r} can be taken for")
        elif known.role != role.value:
            raise Conflict(f"{participant!r} is a {known.role}; a {role.value} needs another name")


def check_name(name: str) -> None:
    """Raises BadInput for a name that no participant can have."""
    if not 1 <= len(name) <= LONGEST_NAME:
        raise BadInput(f"the participant's name has {len(name)} characters, expected 1 to {LONGEST_NAME}")
    if name != " ".join(name.split()) or not is_visible(name):
        raise BadInput(f"the participant's name {name!r} has characters that cannot be seen, or spaces too many")
    if _looks(name) == NOBODY:
        raise BadInput(f"{name!r} is what those without a token are called; a participant needs another name")


def is_visible(text: str) -> bool:
    """Whether a text is one line that shows as what it is: nothing moves a cursor, turns its direction, or hides."""
    seen = text.translate(dict.fromkeys(map(ord, _JOINERS)))
    marks = "".join("m" if unicodedata.category(letter) in ("Mn", "Me") else " " for letter in seen)
    return seen.isprintable() and not _BLANK.search(seen) and "m" * (_MOST_MARKS + 1) not in marks


def _looks(name: str) -> str:
    """What remains of a name where case, width and joiners do not count: two people must not differ by those alone."""
    return unicodedata.normalize("NFKC", name.translate(dict.fromkeys(map(ord, _JOINERS + _STYLES)))).casefold()


def _alike(participants: Sequence[Row[Any]], name: str) -> Row[Any] | None:
    looks = _looks(name)
    return next((row for row in participants if _looks(row.participant) == looks), None)


def _hash(secret: str) -> str:
    return sha256(secret.encode()).hexdigest()


_TOKENS = sa.select(tables.tokens, tables.participants.c.role).join_from(tables.tokens, tables.participants)


def _token(row: Row[Any]) -> Token:
    times: Sequence[datetime | None] = [utc(row._mapping[name]) for name in ("created_at", "expires_at", "revoked_at")]
    created_at, expires_at, revoked_at = times
    assert created_at is not None
    return Token(row.token_id, row.participant, Role(row.role), row.note, created_at, expires_at, revoked_at)
