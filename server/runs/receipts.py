"""Receipts: what the host vouches for of a run that is over, signed and kept. `docs/receipts.md` describes them."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import rfc8785
import sqlalchemy as sa

from arramon.v1 import PROTOCOL
from arramon.v1.chain import episode_head, run_digest
from server.episodes.splits import Split
from server.errors import TakenOver
from server.runs import tables
from server.runs.callers import Caller
from server.runs.database import Database
from server.runs.journal import Journal, no_run
from server.runs.records import Ending, Progress, Run
from server.runs.reports import Report, report_of
from server.runs.signing import SigningKey

FORMAT, VERSION = "arramon-receipt", 1

LIMITS = ("steps_per_phase", "step_seconds", "first_step_seconds", "bank_seconds")
"""Of a run, under the names that the record of it has."""


@dataclass(frozen=True, slots=True)
class Receipt:
    """What was signed, and by whom.

    Attributes:
        payload: JSON by RFC 8785, in UTF-8.
        signature: Ed25519 over these very bytes, 64 bytes.
        public_key: the host's at that time, 32 bytes.
    """

    payload: bytes
    signature: bytes
    public_key: bytes


class Receipts:
    """The receipts of all runs. Safe to use from several threads and processes: the first that is kept stays.

    Args:
        database: where they are kept.
        splits: by name.
        key: signs what is made from now on.
    """

    def __init__(self, database: Database, splits: Mapping[str, Split], key: SigningKey) -> None:
        self._database = database
        self._journal = Journal(database)
        self._splits = splits
        self._key = key

    @property
    def public_key(self) -> bytes:
        """The host's key as it is now, 32 bytes."""
        return self._key.public

    def of(self, caller: Caller, run_id: str) -> Receipt:
        """The receipt of a run, made now if nobody has asked for it before. Of a published run everybody may have it.

        Raises:
            NotFound: if there is none of that id that the caller may see.
            Conflict: while it is being played; or if it has no receipt yet, and the split's data has changed since.
        """
        published = self._journal.is_published(run_id)  # asked first: of none and of another's the same is looked up
        run = self._journal.run(run_id)
        if not (published or caller.may_see(run)):
            raise no_run(run_id)
        return kept_receipt(self._database, run_id) or self._make(run)

    def _make(self, run: Run) -> Receipt:
        report = report_of(run, self._journal, self._splits)
        endings = self._journal.endings(run.run_id)
        payload = rfc8785.dumps(document(self._journal, report, endings, hidden=self._splits[run.split].hidden))
        made = Receipt(payload, self._key.sign(payload), self._key.public)
        with suppress(TakenOver), self._database.write() as connection:  # by another process: what it has made stays
            row = {"run_id": run.run_id, **{name: getattr(made, name) for name in Receipt.__slots__}}
            connection.execute(tables.receipts.insert(), [row])
        return kept_receipt(self._database, run.run_id) or made


def kept_receipt(database: Database, run_id: str) -> Receipt | None:
    """The receipt that is kept of a run, if there is one."""
    table = tables.receipts
    rows = database.read(
        sa.select(table.c.payload, table.c.signature, table.c.public_key).where(table.c.run_id == run_id)
    )
    return Receipt(**rows[0]._mapping) if rows else None


def document(journal: Journal, report: Report, endings: Sequence[Ending], *, hidden: bool) -> dict[str, Any]:
    """What a receipt says, as plain data.

    Args:
        journal: holds the actions.
        report: the run and its scores.
        endings: of all its episodes, in playing order.
        hidden: whether its split is: then nothing is said of a single episode's scores.
    """
    run, progress = report.run, report.progress
    chains = [_Chain.of(journal, run, ending.episode_id) for ending in endings]
    return {
        "format": FORMAT,
        "version": VERSION,
        "run": _run(run, progress, hidden),
        "limits": {name: getattr(run, name) for name in LIMITS},
        "server_version": run.server_version,
        "protocol": PROTOCOL,
        "data_hash": run.data_hash,
        "score_signature": report.signature,
        "causes": progress.causes,
        "reoffers": progress.reoffers,
        "steps": progress.steps,
        "scores": {
            name: {metric: {"mean": i.mean, "low": i.low, "high": i.high} for metric, i in intervals.items()}
            for name, intervals in report.table.rows.items()
        },
        "episodes": [_episode(ending, chain, hidden) for ending, chain in zip(endings, chains, strict=True)],
        "digest": run_digest(run.run_id, ((chain.episode_id, chain.head) for chain in chains)).hex(),
    }


@dataclass(frozen=True, slots=True)
class _Chain:
    """An episode's recorded actions: how many, and the head of their chain."""

    episode_id: str
    steps: int
    head: bytes

    @classmethod
    def of(cls, journal: Journal, run: Run, episode_id: str) -> "_Chain":
        actions = journal.actions(run.run_id, episode_id)
        return cls(episode_id, len(actions), episode_head(run.run_id, episode_id, run.data_hash, actions))


def _run(run: Run, progress: Progress, hidden: bool) -> dict[str, Any]:
    return {
        "run_id": run.run_id,
        "participant": run.participant,
        "agent": run.agent,
        "split": run.split,
        "hidden": hidden,
        "language": run.language,
        "sensors": list(run.sensors),
        "images": list(progress.images),
        "state": run.state,
        "created_at": run.created_at.isoformat(),
        "ended_at": run.ended_at.isoformat() if run.ended_at else None,
    }


def _episode(ending: Ending, chain: _Chain, hidden: bool) -> dict[str, Any]:
    told = {"episode_id": ending.episode_id, "cause": ending.cause, "steps": chain.steps, "head": chain.head.hex()}
    if hidden:
        return told
    return {**told, "scores": {f"turn {number}": turn for number, turn in enumerate(ending.scores, start=1)}}
