"""Storage of corrections to splits: episodes that a host voids or restores, and data that it corrects.

They are append-only. Those of a split are numbered from 1, and its state follows from them in order.
"""

import uuid
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database, utc

_TABLE = tables.corrections

MAX_REASON = 500
"""Maximum characters of a reason."""


class CorrectionKind(StrEnum):
    """Kind of a correction."""

    VOID = "void"
    """Its episodes count in no run's scores from then on."""
    RESTORE = "restore"
    """Its episodes, which were void, count again."""
    RESCORE = "rescore"
    """The data of its episodes changed, and the runs on the data before it were scored again."""


@dataclass(frozen=True, slots=True)
class Correction:
    """A correction of a split by its host.

    Attributes:
        correction_id: 32 hexadecimal digits.
        split: name of the split.
        number: its number among the corrections of the split, from 1.
        kind: its kind.
        made_at: time in UTC.
        reason: the host's own words, one line.
        episodes: ids of the episodes that it is about, sorted.
        data_before, data_after: hashes of the split's data, in hexadecimal; None unless the data was corrected.
    """

    correction_id: str
    split: str
    number: int
    kind: CorrectionKind
    made_at: datetime
    reason: str
    episodes: tuple[str, ...]
    data_before: str | None = None
    data_after: str | None = None

    def changes(self, run_id: str, played: Iterable[str], rescored: frozenset[tuple[str, str]]) -> bool:
        """Return whether it changes the scores of a run.

        Args:
            run_id: id of the run.
            played: ids of its episodes.
            rescored: pairs of a run and a correction for which it was scored again.
        """
        if self.kind is CorrectionKind.RESCORE:
            return (run_id, self.correction_id) in rescored
        return not frozenset(self.episodes).isdisjoint(played)


class Corrections:
    """All corrections. Thread-safe.

    Args:
        database: storage of the corrections.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def on(self, split: str) -> list[Correction]:
        """Return the corrections of a split, in order."""
        query = sa.select(_TABLE).where(_TABLE.c.split == split).order_by(_TABLE.c.number)
        return [_correction(row) for row in self._database.read(query)]

    def voided(self, split: str) -> frozenset[str]:
        """Return the ids of the episodes of a split that are currently void."""
        return voided_by(self.on(split))

    def of_run(self, run_id: str, split: str, played: Iterable[str]) -> list[Correction]:
        """Return the corrections that change the scores of a run, in order.

        Args:
            run_id: id of the run.
            split: its split.
            played: ids of its episodes.
        """
        found = self.on(split)
        if not found:
            return []
        episodes, rescored = frozenset(played), self._rescored(run_id)
        return [one for one in found if one.changes(run_id, episodes, rescored)]

    def add(
        self,
        split: str,
        kind: CorrectionKind,
        reason: str,
        episodes: Iterable[str],
        data: tuple[str, str] | None = None,
    ) -> Correction:
        """Write a correction.

        Args:
            split: name of the split.
            kind: its kind.
            reason: one line.
            episodes: ids of the affected episodes.
            data: hashes of the data before and after it, if it corrects the data.

        Raises:
            TakenOver: if another process wrote one of the same split at the same time.
        """
        before, after = data or (None, None)
        with self._database.write() as connection:
            last = connection.execute(sa.select(sa.func.max(_TABLE.c.number)).where(_TABLE.c.split == split)).scalar()
            made = Correction(
                uuid.uuid4().hex,
                split,
                (last or 0) + 1,
                kind,
                datetime.now(UTC),
                reason,
                tuple(sorted(episodes)),
                before,
                after,
            )
            row = {name: getattr(made, name) for name in Correction.__slots__}
            connection.execute(_TABLE.insert(), [{**row, "kind": kind.value, "episodes": list(made.episodes)}])
        return made

    def note_rescored(self, connection: Connection, run_id: str, correction: Correction) -> None:
        """Record that a run is scored again for a correction, in a given transaction."""
        row = {"run_id": run_id, "correction_id": correction.correction_id}
        connection.execute(tables.rescored_runs.insert(), [row])

    def stamp(self) -> tuple[int, int]:
        """Return a version that changes with each correction and with each run that is scored again."""
        runs = sa.select(sa.func.count()).select_from(tables.rescored_runs).scalar_subquery()
        row = self._database.read(sa.select(sa.func.count().label("made"), runs.label("runs")).select_from(_TABLE))[0]
        return row.made, row.runs

    def _rescored(self, run_id: str) -> frozenset[tuple[str, str]]:
        table = tables.rescored_runs
        rows = self._database.read(sa.select(table).where(table.c.run_id == run_id))
        return frozenset((row.run_id, row.correction_id) for row in rows)


def voided_by(corrections: Sequence[Correction]) -> frozenset[str]:
    """Return the ids of the episodes that are void after a split's corrections, given in order."""
    found = set[str]()
    for correction in corrections:
        if correction.kind is CorrectionKind.VOID:
            found.update(correction.episodes)
        elif correction.kind is CorrectionKind.RESTORE:
            found.difference_update(correction.episodes)
    return frozenset(found)


def _correction(row: Row[Any]) -> Correction:
    values = {name: row._mapping[name] for name in Correction.__slots__}
    fitting = {"kind": CorrectionKind(row.kind), "made_at": utc(row.made_at), "episodes": tuple(row.episodes)}
    return Correction(**{**values, **fitting})
