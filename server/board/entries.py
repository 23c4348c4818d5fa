"""Entries of the leaderboard in the database: published runs and their scores."""

import hashlib
import json
from collections.abc import Mapping, Sequence, Set
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import lru_cache
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from arramon_server.board.cost import NO_COST, Cost
from arramon_server.board.episode_table import EpisodeTable
from arramon_server.board.standings import ReceiptFingerprint, Rows
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.accounts.administration import check_may_act
from arramon_server.runs.accounts.attempts import Attempts, ParticipantKey, attempts_on
from arramon_server.runs.results.receipts import MASKED_VERSION, first_receipt_payload, superseded_receipts
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.corrections import Correction, Corrections
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.journal import Journal, run_of
from arramon_server.runs.storage.records import Run, RunProgress
from arramon_server.scoring.aggregate import Interval, SectionSpread
from arramon_server.scoring.masking import rounded_rows

_KEPT = 2048
"""Maximum number of runs whose scores are cached, about 10 KB each."""


@dataclass(frozen=True, slots=True)
class StoredScores:
    """Scores of an ended run over all its episodes, stored when it was published or rescored.

    Attributes:
        progress: counts of its episodes and steps.
        rows: means and confidence intervals.
        signature: settings under which the scores were reached, in one line.
    """

    progress: RunProgress
    rows: Rows
    signature: str


@dataclass(frozen=True, slots=True)
class PublishedRun:
    """Database record of a run that is or was on the leaderboard.

    Attributes:
        run: the run.
        published_at: time of the publication, in UTC.
        note: note of the publisher; may be empty.
        withdrawn_at: time of the withdrawal, in UTC; None while the run is listed.
        withdrawn_by_host: whether the host withdrew it.
        reproduces: id of the run that it reproduces; None if none.
        cost: what the run cost, as declared.
        rescored: number of times that the run was rescored.
    """

    run: Run
    published_at: datetime
    note: str
    withdrawn_at: datetime | None
    withdrawn_by_host: bool
    reproduces: str | None = None
    cost: Cost = NO_COST
    rescored: int = 0

    @property
    def is_listed(self) -> bool:
        """Whether the run is on the leaderboard now."""
        return self.withdrawn_at is None


class Entries:
    """Stores and reads the entries of the leaderboard. Thread-safe.

    Args:
        database: storage of the entries.

    Attributes:
        corrections: corrections of the splits.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self.corrections = Corrections(database)
        self._scores = lru_cache(_KEPT)(self._read_scores)
        self._receipt_header = lru_cache(_KEPT)(self._read_receipt_header)

    def find(self, run_id: str) -> PublishedRun | None:
        """Return the entry of a run, withdrawn or not; None if it was never published."""
        rows = self._database.read(_ENTRIES.where(tables.entries.c.run_id == run_id))
        return _published(rows[0]) if rows else None

    def listed(self, split: str, language: str | None = None) -> list[PublishedRun]:
        """Return the entries of a split that are not withdrawn, in one language, or in all if None."""
        query = _ENTRIES.where(tables.entries.c.withdrawn_at.is_(None), tables.runs.c.split == split)
        if language is not None:
            query = query.where(tables.runs.c.language == language)
        return [_published(row) for row in self._database.read(query)]

    def stamp(self) -> tuple[int, ...]:
        """Return a version stamp, which changes with every publication, withdrawal, correction and new run.

        Pruned runs are counted too: a number that can decrease could repeat an earlier stamp.
        """
        table = tables.entries
        query = sa.select(
            sa.func.count().label("entries"),
            sa.func.coalesce(sa.func.sum(table.c.revision), 0).label("revisions"),
            *(
                sa.select(sa.func.count()).select_from(runs).scalar_subquery().label(runs.name)
                for runs in (tables.runs, tables.pruned_runs)
            ),
        )
        row = self._database.read(query.select_from(table))[0]
        return row.entries, int(row.revisions), row.runs + row.pruned_runs, *self.corrections.stamp()

    def attempts(self, split: str) -> dict[tuple[ParticipantKey, str], Attempts]:
        """Return the attempts of every participant on a split, by participant and language."""
        return attempts_on(self._database.read, split)

    def reproductions(self, run_id: str) -> list[PublishedRun]:
        """Return the entries that reproduce a run and are not withdrawn, the earliest published first."""
        query = _ENTRIES.where(tables.entries.c.reproduces == run_id, _LISTED)
        return [_published(row) for row in self._database.read(query.order_by(tables.entries.c.published_at))]

    def reproducers(self, split: str) -> dict[str, frozenset[str]]:
        """Return the accounts that reproduced each run of a split, by run id; withdrawn reproductions do not count."""
        c = tables.entries.c
        query = sa.select(c.reproduces, tables.runs.c.account).join_from(tables.entries, tables.runs)
        found: dict[str, set[str]] = {}
        for row in self._database.read(query.where(_LISTED, c.reproduces.is_not(None), tables.runs.c.split == split)):
            found.setdefault(row.reproduces, set()).add(row.account)
        return {run_id: frozenset(accounts) for run_id, accounts in found.items()}

    def languages(self) -> set[tuple[str, str]]:
        """Return the pairs of split and language in which there are entries that are not withdrawn."""
        query = sa.select(tables.runs.c.split, tables.runs.c.language).distinct().join_from(tables.entries, tables.runs)
        return {(row.split, row.language) for row in self._database.read(query.where(_LISTED))}

    def scores(self, run_id: str, rescored: int = 0) -> StoredScores:
        """Return the scores of an entry over all its episodes, including void ones.

        Args:
            run_id: id of the run.
            rescored: number of times that the run was rescored.

        Raises:
            NotFound: if the run has no entry.
        """
        return self._scores(run_id, rescored)

    def was_hidden(self, run_id: str) -> bool:
        """Return whether a run was played on a hidden split, according to its receipt."""
        return self._receipt_header(run_id)[0]

    def masked_rows_without_truth(self, run_id: str, rescored: int = 0) -> Rows:
        """Return the rows to show for a run on a hidden split whose data is no longer served.

        Masked rows are returned as stored. Exact rows, which an earlier release stored, are rounded, because masking
        needs the split's data. The first receipt shows which release stored them: a correction replaces the receipt,
        but stores rows only when it rescores the run.

        Args:
            run_id: id of the run.
            rescored: number of times that the run was rescored.
        """
        scores = self.scores(run_id, rescored)
        if rescored or self._receipt_header(run_id)[1] == MASKED_VERSION:
            return scores.rows
        return rounded_rows(scores.rows, scores.progress.episodes)

    def receipt_fingerprint(self, run_id: str) -> ReceiptFingerprint | None:
        """Return the fingerprint of a run's receipt; None if there is no receipt."""
        rows = self._database.read(sa.select(tables.receipts).where(tables.receipts.c.run_id == run_id))
        if not rows:
            return None
        digest = hashlib.sha256(rows[0].payload).digest()
        return ReceiptFingerprint(digest, rows[0].public_key, tuple(superseded_receipts(self._database, run_id)))

    def corrections_of(self, run: Run) -> list[Correction]:
        """Return the corrections of the split that change the scores of a run, in order."""
        return self.corrections.of_run(run.run_id, run.split, self.all_episode_scores(run.run_id).ids)

    def counted_episode_scores(self, run_id: str) -> EpisodeTable:
        """Return the scores of the episodes that count for an entry, see `void_and_left_out`.

        Raises:
            NotFound: if the run has no entry.
        """
        _, left_out = self.void_and_left_out(run_id, self.corrections.voided(self.split_of(run_id)))
        return self.all_episode_scores(run_id).without(left_out)

    def split_of(self, run_id: str) -> str:
        """Return the name of an entry's split."""
        query = sa.select(tables.runs.c.split).where(tables.runs.c.run_id == run_id)
        return str(self._database.read(query)[0].split)

    def void_and_left_out(self, run_id: str, voided: Set[str]) -> tuple[frozenset[str], frozenset[str]]:
        """Return which of an entry's episodes are void, and which of them are left out of its scores.

        The two are equal unless all its episodes are void: such a run, which is partial and not ranked, keeps its
        scores.

        Args:
            run_id: id of the run.
            voided: ids of the split's episodes that are void.

        Raises:
            NotFound: if the run has no entry.
        """
        if not voided:
            return frozenset(), frozenset()
        played = frozenset(self.all_episode_scores(run_id).ids)
        return played & voided, frozenset() if played <= voided else played & voided

    def all_episode_scores(self, run_id: str) -> EpisodeTable:
        """Return the scores of all episodes, including void ones.

        Earlier releases stored no episode scores, or no play digest for hidden splits; these are read from the journal
        and stored.

        Raises:
            NotFound: if the run has no entry.
        """
        table = tables.entries
        rows = self._database.read(sa.select(table.c.episodes).where(table.c.run_id == run_id))
        if not rows:
            raise NotFound(f"there is no run {quoted(run_id)} on the leaderboard")
        found = EpisodeTable.unpacked(rows[0].episodes) if rows[0].episodes else None
        if found is None or (not found.play_digest and self.was_hidden(run_id)):
            journal = Journal(self._database)
            found = EpisodeTable.from_endings(journal.endings(run_id), journal.play_digest(journal.run(run_id)))
            with self._database.write() as connection:
                connection.execute(table.update().where(table.c.run_id == run_id).values(episodes=found.packed()))
        return found

    def publish(
        self,
        run_id: str,
        note: str,
        scores: StoredScores,
        episodes: EpisodeTable,
        *,
        by_host: bool,
        cost: Cost | None = None,
        reproduces: str | None = None,
    ) -> bool:
        """Publish a run, also a withdrawn one; if it is listed already, replace its note, and its cost if given.

        `reproduces` is the id of the run that it reproduces; empty for none, None to leave it unchanged.

        Only a host can publish a run that a host has withdrawn. The publishing SQL statement checks this itself, so a
        concurrent publication cannot undo a host's withdrawal.

        Returns:
            Whether the run was published.

        Raises:
            TakenOver: if another process published the run at the same time.
            Forbidden: if its account is banned and `by_host` is False.
        """
        table = tables.entries
        now = datetime.now(UTC)
        again = sa.case((table.c.withdrawn_at.is_(None), table.c.published_at), else_=now)
        values = {
            "note": note,
            "published_at": again,
            "withdrawn_at": None,
            "withdrawn_by_host": False,
            "revision": table.c.revision + 1,
            **({} if cost is None else {"cost": cost.to_stored()}),
        }
        if reproduces is not None:
            values["reproduces"] = reproduces or None
        with self._database.write() as connection:
            if not by_host:
                owner = sa.select(tables.runs.c.account).where(tables.runs.c.run_id == run_id)
                check_may_act(connection, connection.execute(owner).scalar())
            this_run = table.c.run_id == run_id
            may = sa.true() if by_host else table.c.withdrawn_by_host.is_(False)
            if connection.execute(table.update().where(this_run, may).values(values)).rowcount:
                return True
            if connection.execute(sa.select(table.c.run_id).where(this_run)).all():
                return False
            row = {"run_id": run_id, "published_at": now, "note": note, "scores": _written(scores)}
            row |= {"episodes": episodes.packed(), "cost": cost.to_stored() if cost else None}
            row |= {"reproduces": reproduces or None}
            connection.execute(table.insert().values(row))
            return True

    def withdraw(self, run_id: str, *, by_host: bool) -> None:
        """Withdraw a run from the leaderboard, but keep its row. A host may withdraw a withdrawn run."""
        table = tables.entries
        values = {
            "withdrawn_at": datetime.now(UTC),
            "withdrawn_by_host": by_host,
            "revision": table.c.revision + 1,
        }
        with self._database.write() as connection:
            may = sa.true() if by_host else _LISTED
            connection.execute(table.update().where(table.c.run_id == run_id, may).values(values))

    def _read_receipt_header(self, run_id: str) -> tuple[bool, int]:
        """Return whether a run's split was hidden, and its first receipt's version; False and 0 without a receipt."""
        payload = first_receipt_payload(self._database, run_id)
        if payload is None:
            return False, 0
        content = json.loads(payload)
        return bool(content["run"]["hidden"]), int(content["version"])

    def rescore(self, connection: Connection, run_id: str, scores: StoredScores, episodes: EpisodeTable) -> None:
        """Replace the stored scores of a run within a transaction; do nothing if it was never published."""
        table = tables.entries
        values = {"scores": _written(scores), "episodes": episodes.packed(), "revision": table.c.revision + 1}
        connection.execute(table.update().where(table.c.run_id == run_id).values(values))

    def _read_scores(self, run_id: str, _rescored: int) -> StoredScores:
        query = sa.select(tables.entries.c.scores).where(tables.entries.c.run_id == run_id)
        rows = self._database.read(query)
        if not rows:
            raise NotFound(f"there is no run {quoted(run_id)} on the leaderboard")
        return _read(rows[0].scores)


_LISTED = tables.entries.c.withdrawn_at.is_(None)

_ENTRIES = sa.select(
    tables.runs,
    *(
        tables.entries.c[name]
        for name in ("published_at", "note", "withdrawn_at", "withdrawn_by_host", "reproduces", "cost")
    ),
    sa.select(sa.func.count())
    .select_from(tables.rescored_runs)
    .where(tables.rescored_runs.c.run_id == tables.runs.c.run_id)
    .scalar_subquery()
    .label("rescored"),
).join_from(tables.entries, tables.runs)


def _published(row: Row[Any]) -> PublishedRun:
    published_at, withdrawn_at = utc(row.published_at), utc(row.withdrawn_at)
    assert published_at is not None
    return PublishedRun(
        run_of(row),
        published_at,
        row.note,
        withdrawn_at,
        row.withdrawn_by_host,
        row.reproduces,
        Cost.from_stored(row.cost),
        row.rescored,
    )


def _written(scores: StoredScores) -> dict[str, Any]:
    rows = {row: {metric: _numbers(value) for metric, value in values.items()} for row, values in scores.rows.items()}
    return {"progress": asdict(scores.progress), "rows": rows, "signature": scores.signature}


def _read(written: Mapping[str, Any]) -> StoredScores:
    kept = written["progress"]  # written by this release or, in an imported database, by another one
    known = {name: kept[name] for name in RunProgress.__slots__ if name in kept}
    progress = RunProgress(**{**known, "images": tuple(known["images"])})
    rows = {
        row: {metric: _interval(numbers) for metric, numbers in values.items()}
        for row, values in written["rows"].items()
    }
    return StoredScores(progress, rows, written["signature"])


def _numbers(value: Interval) -> list[float]:
    """Return mean, low and high, followed by the fields of `SectionSpread` if the interval has them."""
    sections = value.sections
    further = [] if sections is None else [sections.deviation, sections.low, sections.high]
    return [value.mean, value.low, value.high, *further]


def _interval(numbers: Sequence[float]) -> Interval:
    mean, low, high, *further = numbers
    return Interval(mean, low, high, SectionSpread(*further) if further else None)
