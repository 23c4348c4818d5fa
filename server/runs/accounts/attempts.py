"""Counts of participants' attempts on a split: every run that was created, with any agent, pruned ones included."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import sqlalchemy as sa
from sqlalchemy.engine import Row

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.records import Run

ReadQuery: TypeAlias = Callable[[sa.Select[Any]], Sequence[Row[Any]]]

ParticipantKey: TypeAlias = tuple[str | None, str]
"""An account and "", or None and the name given by an anonymous participant."""


@dataclass(frozen=True, slots=True)
class Attempts:
    """Counts of a participant's runs on a split, in one or several languages.

    Attributes:
        begun: runs that were created, also those that were cancelled, withdrawn or never published.
        published: runs that are listed on the leaderboard.
    """

    begun: int = 0
    published: int = 0

    def __add__(self, other: "Attempts") -> "Attempts":
        """Return the sum of both."""
        return Attempts(self.begun + other.begun, self.published + other.published)


NO_ATTEMPTS = Attempts()


def participant_key(run: Run) -> ParticipantKey:
    """Return the key of the participant for whom a run counts as an attempt."""
    return (None, run.participant) if run.account is None else (run.account, "")


def attempts_on(read: ReadQuery, split: str) -> dict[tuple[ParticipantKey, str], Attempts]:
    """Return the attempts of every participant on a split, by participant and language."""
    runs, entries = _begun(lambda table: table.c.split == split), tables.entries
    name = sa.case((runs.c.account.is_(None), runs.c.participant), else_="").label("name")
    listed = sa.func.count().filter(entries.c.run_id.is_not(None), entries.c.withdrawn_at.is_(None))
    query = (
        sa.select(runs.c.account, name, runs.c.language, sa.func.count().label("begun"), listed.label("published"))
        .select_from(runs.outerjoin(entries, entries.c.run_id == runs.c.run_id))
        .group_by(runs.c.account, name, runs.c.language)
    )
    return {((row.account, row.name), row.language): Attempts(row.begun, row.published) for row in read(query)}


def attempt_number(read: ReadQuery, run: Run) -> tuple[int, int]:
    """Return the number of a run among its participant's runs on the split in the language, from 1, and their count."""

    def is_alike(table: sa.Table) -> sa.ColumnElement[bool]:
        of_account = table.c.account == run.account
        if run.account is None:
            of_account = table.c.account.is_(None) & (table.c.participant == run.participant)
        return sa.and_(table.c.split == run.split, table.c.language == run.language, of_account)

    c = _begun(is_alike).c
    before = sa.tuple_(c.created_at, c.run_id) <= sa.tuple_(sa.literal(run.created_at, c.created_at.type), run.run_id)
    query: Any = sa.select(sa.func.count().filter(before).label("number"), sa.func.count().label("begun")).select_from(
        c.run_id.table
    )
    row = read(query)[0]
    return row.number, row.begun


def _begun(which: Callable[[sa.Table], sa.ColumnElement[bool]]) -> sa.Subquery:
    """Return the runs that meet a condition, pruned ones included, in one query, so that each is counted once.

    Args:
        which: returns the condition for one of the two tables, which share these columns.
    """
    names = ("run_id", "account", "participant", "split", "language", "created_at")
    each = [sa.select(*(table.c[name] for name in names)).where(which(table)) for table in _TABLES]
    return sa.union_all(*each).subquery()


_TABLES = (tables.runs, tables.pruned_runs)
