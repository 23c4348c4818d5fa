"""Administration of accounts by the host: list, rename, ban. Tokens are in `accounts`."""

from dataclasses import dataclass
from datetime import UTC, datetime

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import BadInput, Conflict, Forbidden, NotFound, TakenOver
from arramon_server.runs.accounts.accounts import ANONYMOUS_NAME, ban_clause, check_name, check_name_free
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.records import RUNNING
from arramon_server.visible_text import is_visible

LONGEST_REASON = 500
"""Maximum characters in the reason for a ban."""


@dataclass(frozen=True, slots=True)
class Account:
    """Summary of an account, with the numbers of its tokens and runs.

    Attributes:
        participant: its name.
        role: its role.
        created_at: time in UTC.
        earlier_names: names that it had before, sorted.
        tokens: number of its tokens that are neither revoked nor expired.
        runs: runs that it began, pruned ones included.
        running: unfinished runs.
        published: runs that are listed on the leaderboard.
        banned_at: since when it is banned, in UTC; None if it is not.
        ban_reason: reason for the ban; may be empty.
    """

    participant: str
    role: Role
    created_at: datetime
    earlier_names: tuple[str, ...]
    tokens: int
    runs: int
    running: int
    published: int
    banned_at: datetime | None
    ban_reason: str


class Administration:
    """Changes of accounts by the host. Thread-safe; servers notice within two seconds.

    Args:
        database: storage of the accounts.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self) -> list[Account]:
        """Return all accounts, oldest first."""
        c = tables.participants.c
        query = sa.select(tables.participants, *(count.label(name) for name, count in _counts().items()))
        rows = self._database.read(query.where(c.participant != ANONYMOUS_NAME).order_by(c.created_at, c.participant))
        earlier: dict[str, list[str]] = {}
        for row in self._database.read(sa.select(tables.earlier_names).order_by(tables.earlier_names.c.name)):
            earlier.setdefault(row.participant, []).append(row.name)
        return [
            Account(
                row.participant,
                Role(row.role),
                utc(row.created_at) or row.created_at,
                tuple(earlier.get(row.participant, ())),
                row.tokens,
                row.runs + row.pruned,
                row.running,
                row.published,
                utc(row.banned_at),
                row.ban_reason,
            )
            for row in rows
        ]

    def rename(self, old: str, new: str) -> None:
        """Give an account another name, with its tokens, limits and runs. The old name stays reserved for it.

        Its runs are shown under the new name. Signed receipts keep the old one: they never change.

        Raises:
            NotFound: if there is no such account.
            BadInput: if no participant may have the new name.
            Conflict: if the new name can be confused with another account's, present or earlier.
        """
        check_name(new)
        with self._database.write() as connection:
            row = _row(connection, old)
            if old == new:
                raise Conflict(f"the account has the name {new!r} already")
            check_name_free(connection, new, except_name=old)
            connection.execute(tables.participants.insert(), [{**row._mapping, "participant": new}])
            for column in _REFERENCES:
                connection.execute(column.table.update().where(column == old).values({column.name: new}))
            for runs in (tables.runs, tables.pruned_runs):
                connection.execute(runs.update().where(runs.c.account == new).values(participant=new))
            _touch_entries(connection, new)
            c = tables.earlier_names.c
            connection.execute(tables.earlier_names.delete().where(c.name == new))
            once = {"name": old, "participant": new, "until": datetime.now(UTC)}
            connection.execute(tables.earlier_names.insert(), [once])
            connection.execute(tables.participants.delete().where(tables.participants.c.participant == old))

    def ban(self, participant: str, reason: str = "") -> tuple[int, list[str]]:
        """Ban an account: refuse its tokens, and withdraw its runs from the leaderboard, as by the host.

        Args:
            participant: name of the account.
            reason: reason shown to the participant; may be empty.

        Returns:
            The number of withdrawn runs, and the ids of unfinished runs, which cannot be played any more. If the
            account is banned already, its runs that were listed since are withdrawn.

        Raises:
            NotFound: if there is no such account.
            BadInput: if the reason is too long or not one visible line.
        """
        if len(reason) > LONGEST_REASON or not is_visible(reason):
            raise BadInput(f"the reason is {reason[:60]!r}, expected one line of at most {LONGEST_REASON} characters")
        with self._database.write() as connection:
            row = _row(connection, participant)
            at = utc(row.banned_at) or datetime.now(UTC)
            values = {"banned_at": at, "ban_reason": reason or row.ban_reason}
            mine = tables.participants.c.participant == participant
            connection.execute(tables.participants.update().where(mine).values(values))
            # The time tells `unban` which runs were withdrawn with the ban.
            withdrawn = {"withdrawn_at": at, "withdrawn_by_host": True, "revision": tables.entries.c.revision + 1}
            listed = _is_entry_of(participant) & tables.entries.c.withdrawn_at.is_(None)
            number = connection.execute(tables.entries.update().where(listed).values(withdrawn)).rowcount
            c = tables.runs.c
            running = sa.select(c.run_id).where(c.account == participant, c.state == RUNNING)
            ordered = running.order_by(c.created_at, c.run_id)
            return number, [run.run_id for run in connection.execute(ordered)]

    def unban(self, participant: str) -> int:
        """End a ban: tokens work again, and the runs that were withdrawn with it are listed again.

        Returns:
            The number of runs that are listed again. What the host withdrew before or since stays so, and runs that
            were cancelled stay cancelled.

        Raises:
            NotFound: if there is no such account.
            Conflict: if it is not banned.
        """
        with self._database.write() as connection:
            at = utc(_row(connection, participant).banned_at)
            if at is None:
                raise Conflict(f"{participant!r} is not banned")
            mine = tables.participants.c.participant == participant
            connection.execute(tables.participants.update().where(mine).values(banned_at=None, ban_reason=""))
            c = tables.entries.c
            by_ban = _is_entry_of(participant) & c.withdrawn_by_host & (c.withdrawn_at == at)
            listed = {"withdrawn_at": None, "withdrawn_by_host": False, "revision": c.revision + 1}
            return connection.execute(tables.entries.update().where(by_ban).values(listed)).rowcount


def check_may_act(connection: Connection, account: str | None) -> None:
    """Check, in the transaction of a change, that its account still exists and is not banned, and keep it so.

    A server process caches callers for up to two seconds.

    Raises:
        Forbidden: if it is banned.
        TakenOver: if it was renamed.
    """
    if account is None:
        return
    table = tables.participants
    query = sa.select(table).where(table.c.participant == account)
    row = connection.execute(query.with_for_update(read=True)).one_or_none()  # a ban waits for the change
    if row is None:
        raise TakenOver(f"the account {account!r} was renamed just now; try again")
    if row.banned_at is not None:
        raise Forbidden(ban_clause(account, row.ban_reason))


def earlier_names(database: Database, participant: str | None) -> frozenset[str]:
    """Return the former names of an account."""
    c = tables.earlier_names.c
    return frozenset(row.name for row in database.read(sa.select(c.name).where(c.participant == participant)))


_REFERENCES = (
    tables.earlier_names.c.participant,
    tables.tokens.c.participant,
    tables.quotas.c.participant,
    tables.runs.c.account,
    tables.pruned_runs.c.account,
)
"""Columns that refer to an account by its name."""


def _counts() -> dict[str, sa.ScalarSelect[int]]:
    """Return subqueries for the counts of an account, by name, as columns of a query for participants."""
    account, tokens, runs = tables.participants.c.participant, tables.tokens, tables.runs
    is_valid = tokens.c.revoked_at.is_(None) & (
        tokens.c.expires_at.is_(None) | (tokens.c.expires_at > datetime.now(UTC))
    )
    number = sa.select(sa.func.count())
    queries = {
        "tokens": number.where(tokens.c.participant == account, is_valid),
        "runs": number.where(runs.c.account == account),
        "pruned": number.where(tables.pruned_runs.c.account == account),
        "running": number.where(runs.c.account == account, runs.c.state == RUNNING),
        "published": number.select_from(runs.join(tables.entries)).where(
            runs.c.account == account, tables.entries.c.withdrawn_at.is_(None)
        ),
    }
    return {name: query.correlate(tables.participants).scalar_subquery() for name, query in queries.items()}


def _row(connection: Connection, participant: str) -> sa.Row[tuple[object, ...]]:
    if participant == ANONYMOUS_NAME:
        raise BadInput(f"{ANONYMOUS_NAME!r} stands for all callers without a token; see `serve --no-anonymous`")
    table = tables.participants
    query = sa.select(table).where(table.c.participant == participant)
    # Locked before the rows of its runs, as by `check_may_act`, so that no two transactions wait for each other.
    row = connection.execute(query.with_for_update()).one_or_none()
    if row is None:
        raise NotFound(f"there is no account {participant!r}; `arramon-server account list` shows them")
    return row


def _is_entry_of(account: str) -> sa.ColumnElement[bool]:
    return tables.entries.c.run_id.in_(sa.select(tables.runs.c.run_id).where(tables.runs.c.account == account))


def _touch_entries(connection: Connection, account: str) -> None:
    """Change the version of an account's entries, so that caches of the leaderboard notice the change."""
    c = tables.entries.c
    connection.execute(tables.entries.update().where(_is_entry_of(account)).values(revision=c.revision + 1))
