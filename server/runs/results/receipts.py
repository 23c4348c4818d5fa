"""Receipts: the host's signed and stored statements of the results of ended runs, see `docs/reference/receipts.md`.

A receipt never changes. When the host corrects a split, a new receipt supersedes it and states the changes; the old one
is kept.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeAlias

import rfc8785
import sqlalchemy as sa

from arramon.v1 import PROTOCOL
from arramon.v1.chain import episode_ending, episode_head, run_digest
from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict, NotFound, TakenOver, quoted
from arramon_server.runs.accounts.attempts import attempt_number
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.results.reports import Report, report_of
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.corrections import Correction, Corrections
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.epoch_store import EpochStore
from arramon_server.runs.storage.journal import Journal, run_not_found
from arramon_server.runs.storage.records import EpisodeEnding, Run, RunProgress
from arramon_server.scoring.aggregate import METHOD
from arramon_server.scoring.masking import MASKED_METHOD

FORMAT, VERSION, MASKED_VERSION = "arramon-receipt", 1, 2
"""Header of the payload. On hidden splits new receipts have MASKED_VERSION: masked scores, no steps, and a
commitment in place of each episode's cause. Receipts that earlier releases signed there have VERSION."""

ATTEMPTS = "attempts"
"""Field with the participant's attempts at the time of signing, which cannot be derived again later."""

EPOCH = "epoch"
"""Field with the commitment of the epoch that the split is, in hexadecimal."""

CORRECTIONS, REVISION, VOIDED = "corrections", "revision", "voided"
"""Fields with the corrections applied to the scores, with the superseded receipt, and with the void episodes."""

UNDERIVED = frozenset((ATTEMPTS, EPOCH, CORRECTIONS, REVISION))
"""Fields that cannot be derived from a run's actions and its split."""

ActionsOf: TypeAlias = Callable[[str, str], Sequence[int]]
"""Returns the recorded actions of a run's episode, given the ids of both."""

LIMITS = ("steps_per_phase", "step_seconds", "bank_seconds")
"""Field names of a run's limits, in `Run` and in a receipt."""


@dataclass(frozen=True, slots=True)
class SignedReceipt:
    """A statement of a run's results, signed by the host.

    Attributes:
        payload: canonical JSON (RFC 8785), in UTF-8.
        signature: Ed25519 signature over the bytes of the payload, 64 bytes.
        public_key: public key of the signature, 32 bytes.
    """

    payload: bytes
    signature: bytes
    public_key: bytes


@dataclass(frozen=True, slots=True)
class SupersededReceipt:
    """A receipt that was superseded by another one.

    Attributes:
        number: its place among the receipts of its run, from 1.
        superseded_at: time in UTC.
        digest: SHA-256 of its payload, 32 bytes.
    """

    number: int
    superseded_at: datetime
    digest: bytes


class Receipts:
    """Receipts of all runs. Thread-safe and process-safe.

    The first receipt stored for a run is final until the host corrects its split.

    Args:
        database: storage of the receipts.
        splits: served splits, by name.
        key: key that signs new receipts.
        closing: when the leaderboards of splits close.
    """

    def __init__(
        self, database: Database, splits: Mapping[str, Split], key: SigningKey, closing: ClosingTimes = NEVER_CLOSES
    ) -> None:
        self._database = database
        self._journal = Journal(database)
        self._splits = splits
        self._key = key
        self._corrections = Corrections(database)
        self._closing = closing

    @property
    def public_key(self) -> bytes:
        """Current public key of the host, 32 bytes."""
        return self._key.public

    def of(self, caller: Caller, run_id: str, number: int = 0) -> SignedReceipt:
        """Return the receipt of a run, and create it if there is none. All callers may get those of published runs.

        If the host has corrected the split since it was signed, it is superseded first.

        Args:
            caller: caller of the request.
            run_id: id of the run.
            number: place of a superseded receipt among those of the run, from 1; 0 for the present one.

        Raises:
            NotFound: if there is no such run that the caller may see, or no superseded receipt of that number.
            Conflict: if the run is still being played, or it has no receipt and the data of the split has changed; or
                if its leaderboard is frozen, and the run is another participant's.
        """
        published = self._journal.is_published(
            run_id
        )  # first, so that missing runs and those of others cause the same queries
        run = self._journal.run(run_id)
        if not (published or caller.may_see(run)):
            raise run_not_found(run_id)
        if not caller.may_see_withheld(run, published=published):
            self._closing.check_shown(run.split)
        if number:
            return self._superseded(run_id, number)
        self.renew(run)
        return stored_receipt(self._database, run_id) or self._make(run)

    def renew(self, run: Run) -> bool:
        """Supersede the receipt of a run if the host has corrected its split since; return whether it did.

        Nothing is done for a run without a receipt, or without scores: if the data of its split is missing, or all its
        episodes are void.
        """
        table = tables.receipts
        rows = self._database.read(sa.select(table.c.payload, table.c.corrections).where(table.c.run_id == run.run_id))
        corrections = self._corrections.on(run.split)
        if not rows or len(corrections) <= rows[0].corrections:
            return False
        old = rows[0]
        changes = self._changes(run)
        if not any(change.number > old.corrections for change in changes):
            return False
        number = 1 + self._database.read(_count_superseded(run.run_id))[0][0]
        now = datetime.now(UTC)
        revision = {
            "number": number,
            "made_at": now.isoformat(timespec="seconds"),
            "supersedes": hashlib.sha256(old.payload).hexdigest(),
        }
        try:
            made = self._sign(run, changes, {ATTEMPTS: json.loads(old.payload).get(ATTEMPTS), REVISION: revision})
        except Conflict:
            return False
        mine = sa.and_(table.c.run_id == run.run_id, table.c.corrections == old.corrections)
        at = sa.literal(now, _SUPERSEDED.c.superseded_at.type)
        kept = sa.select(table.c.run_id, sa.literal(number), at, *(table.c[name] for name in SignedReceipt.__slots__))
        # If another process is first, it has written the same scores.
        with suppress(TakenOver), self._database.write() as connection:
            connection.execute(_SUPERSEDED.insert().from_select(_SUPERSEDED.c.keys(), kept.where(mine)))
            connection.execute(table.update().where(mine).values(corrections=len(corrections), **_columns(made)))
        return True

    def _superseded(self, run_id: str, number: int) -> SignedReceipt:
        c = _SUPERSEDED.c
        query = sa.select(c.payload, c.signature, c.public_key).where(c.run_id == run_id, c.number == number)
        rows = self._database.read(query)
        if not rows:
            raise NotFound(f"run {quoted(run_id)} has no superseded receipt {number}")
        return SignedReceipt(**rows[0]._mapping)

    def _make(self, run: Run) -> SignedReceipt:
        corrections = len(self._corrections.on(run.split))  # first: what is corrected from here on supersedes it
        number, begun = attempt_number(self._database.read, run)
        made = self._sign(run, self._changes(run), {ATTEMPTS: {"number": number, "begun": begun}})
        with (
            suppress(TakenOver),
            self._database.write() as connection,
        ):  # another process was first: its receipt is final
            row = {"run_id": run.run_id, "corrections": corrections, **_columns(made)}
            connection.execute(tables.receipts.insert(), [row])
        return stored_receipt(self._database, run.run_id) or made

    def _sign(self, run: Run, changes: Sequence[Correction], further: Mapping[str, Any]) -> SignedReceipt:
        """Return a signed receipt of the current scores of a run, without storing it."""
        report = report_of(run, self._journal, self._splits)
        endings = self._journal.endings(run.run_id)
        hidden = self._splits[run.split].hidden
        content = receipt_content(self._journal.actions, report, endings, hidden=hidden, masked=hidden)
        epoch = EpochStore(self._database).find(run.split)
        if epoch is not None:
            content[EPOCH] = epoch.commitment.hex()
        if changes:
            content[CORRECTIONS] = [_correction(change) for change in changes]
        payload = rfc8785.dumps({**content, **{name: value for name, value in further.items() if value is not None}})
        return SignedReceipt(payload, self._key.sign(payload), self._key.public)

    def _changes(self, run: Run) -> list[Correction]:
        played = [ending.episode_id for ending in self._journal.endings(run.run_id)]
        return self._corrections.of_run(run.run_id, run.split, played)


def stored_receipt(database: Database, run_id: str) -> SignedReceipt | None:
    """Return the stored receipt of a run; None if there is none."""
    table = tables.receipts
    rows = database.read(
        sa.select(table.c.payload, table.c.signature, table.c.public_key).where(table.c.run_id == run_id)
    )
    return SignedReceipt(**rows[0]._mapping) if rows else None


_SUPERSEDED = tables.superseded_receipts


def _count_superseded(run_id: str) -> sa.Select[Any]:
    return sa.select(sa.func.count()).select_from(_SUPERSEDED).where(_SUPERSEDED.c.run_id == run_id)


def _columns(receipt: SignedReceipt) -> dict[str, bytes]:
    return {name: getattr(receipt, name) for name in SignedReceipt.__slots__}


def superseded_receipts(database: Database, run_id: str) -> list[SupersededReceipt]:
    """Return the superseded receipts of a run, in order."""
    query = sa.select(_SUPERSEDED).where(_SUPERSEDED.c.run_id == run_id).order_by(_SUPERSEDED.c.number)
    return [
        SupersededReceipt(row.number, utc(row.superseded_at) or row.superseded_at, hashlib.sha256(row.payload).digest())
        for row in database.read(query)
    ]


def first_receipt_payload(database: Database, run_id: str) -> bytes | None:
    """Return the payload of a run's first receipt, superseded or not; None if there is no receipt."""
    mine = _SUPERSEDED.c.run_id == run_id
    rows = database.read(sa.select(_SUPERSEDED.c.payload).where(mine).order_by(_SUPERSEDED.c.number).limit(1))
    if rows:
        return bytes(rows[0].payload)
    present = stored_receipt(database, run_id)
    return present.payload if present is not None else None


def receipt_content(
    actions_of: ActionsOf, report: Report, endings: Sequence[EpisodeEnding], *, hidden: bool, masked: bool
) -> dict[str, Any]:
    """Return the content of a receipt as plain data.

    Args:
        actions_of: source of the actions.
        report: report of the run.
        endings: endings of all episodes of the run, in playing order.
        hidden: whether the split is hidden; the scores of single episodes are then left out.
        masked: whether the content is that of MASKED_VERSION.
    """
    run, progress = report.run, report.progress
    chains = [_HashChain.of(actions_of, run, ending) for ending in endings]
    return {
        "format": FORMAT,
        "version": MASKED_VERSION if masked else VERSION,
        "run": _run(run, progress, hidden),
        "limits": {name: getattr(run, name) for name in LIMITS},
        "server_version": run.server_version,
        "protocol": PROTOCOL,
        "data_hash": run.data_hash,
        "score_signature": report.signature,
        "causes": progress.causes,
        "reoffers": progress.reoffers,
        **({} if masked else {"steps": progress.steps}),
        "intervals": MASKED_METHOD if masked else METHOD,
        "scores": {
            name: {metric: {"mean": i.mean, "low": i.low, "high": i.high} for metric, i in intervals.items()}
            for name, intervals in report.table.rows.items()
        },
        "episodes": [
            _masked_episode(ending, chain)
            if masked
            else _episode(ending, chain, hidden or ending.episode_id in report.voided)
            for ending, chain in zip(endings, chains, strict=True)
        ],
        **({VOIDED: sorted(report.voided)} if report.voided else {}),
        "digest": run_digest(run.run_id, ((chain.episode_id, chain.head) for chain in chains)).hex(),
    }


@dataclass(frozen=True, slots=True)
class _HashChain:
    """Hash chain of an episode's actions: their number, its head, and the commitment to the episode's cause."""

    episode_id: str
    steps: int
    head: bytes
    ending: bytes

    @classmethod
    def of(cls, actions_of: ActionsOf, run: Run, ending: EpisodeEnding) -> "_HashChain":
        episode_id, actions = ending.episode_id, actions_of(run.run_id, ending.episode_id)
        head = episode_head(run.run_id, episode_id, run.data_hash, actions)
        return cls(episode_id, len(actions), head, episode_ending(run.run_id, episode_id, ending.cause, actions))


def _run(run: Run, progress: RunProgress, hidden: bool) -> dict[str, Any]:
    return {
        "run_id": run.run_id,
        "participant": run.participant,
        "agent": run.agent,
        "split": run.split,
        "hidden": hidden,
        "language": run.language,
        "sensors": list(run.sensors),
        # Left out if empty, so that receipts from before there were such fields stay the same.
        **({"agent_arguments": dict(run.agent_arguments)} if run.agent_arguments else {}),
        **({"code": run.code.named()} if run.code else {}),
        "images": list(progress.images),
        "state": run.state,
        "created_at": run.created_at.isoformat(),
        "ended_at": run.ended_at.isoformat() if run.ended_at else None,
    }


def _correction(correction: Correction) -> dict[str, Any]:
    data = {name: getattr(correction, name) for name in ("data_before", "data_after")}
    return {
        "kind": correction.kind.value,
        "made_at": correction.made_at.isoformat(timespec="seconds"),
        "reason": correction.reason,
        "episodes": list(correction.episodes),
        **{name: value for name, value in data.items() if value is not None},
    }


def _masked_episode(ending: EpisodeEnding, chain: _HashChain) -> dict[str, Any]:
    return {"episode_id": ending.episode_id, "head": chain.head.hex(), "ending": chain.ending.hex()}


def _episode(ending: EpisodeEnding, chain: _HashChain, without_scores: bool) -> dict[str, Any]:
    content = {"episode_id": ending.episode_id, "cause": ending.cause, "steps": chain.steps, "head": chain.head.hex()}
    if without_scores:
        return content
    return {**content, "scores": {f"turn {number}": turn for number, turn in enumerate(ending.scores, start=1)}}
