"""Published runs with given scores, written to the journal without playing, and standings from numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from itertools import chain, repeat
from pathlib import Path

import numpy as np
import sqlalchemy as sa

from arramon_server.board.board import Board
from arramon_server.board.comparisons import ComparisonFamily, versions_of_standing
from arramon_server.board.entries import Entries
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.publisher import Publisher
from arramon_server.board.standings import COLUMNS, Entry, Mark, Standing
from arramon_server.episodes.epoch_statement import EpochStatement, epoch_split_name, secret_digest
from arramon_server.episodes.splits import Split
from arramon_server.runs.accounts.callers import HOST, Caller
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.epoch_store import EpochStore
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import (
    COMPLETE,
    NO_CODE,
    RUNNING,
    CodeReference,
    CommitBatch,
    EpisodeEnding,
    Run,
    RunProgress,
)
from arramon_server.scoring.aggregate import ROWS, Interval
from arramon_server.scoring.episode_scores import METRICS
from tests import tiny

NOON = datetime(2030, 1, 1, 12, tzinfo=UTC)
STEPS, CLOCKS = 150, ClockSettings(60.0, 3600.0)
"""Of the runs, and of the board that shows them."""


class LeaderboardBackend:
    """Database with a leaderboard, and two splits, one of them hidden; a third one for training alone if wanted."""

    def __init__(self, folder: Path, url: str = "", *, training: bool = False) -> None:
        self.splits: dict[str, Split] = {
            "secret": tiny.write(folder, "secret", 3, hidden=True),
            "tiny": tiny.write(folder),
        }
        if training:
            self.splits["extra"] = tiny.write(folder, "extra", training=True)
        self.database = Database(url or f"sqlite:///{folder / 'journal.db'}")
        self.journal = Journal(self.database)
        self.entries = Entries(self.database)
        receipts = Receipts(self.database, self.splits, SigningKey(folder / "key.pem"))
        self.publisher = Publisher(self.journal, self.splits, self.entries, receipts)
        self.board = Board(self.entries, self.splits, steps_per_phase=STEPS, clocks=CLOCKS)
        self.epochs = EpochStore(self.database)

    @property
    def epoch_board(self) -> EpochBoard:
        """The epochs, on the present board."""
        return EpochBoard(self.board, self.entries, self.epochs, self.journal, self.splits)

    def epoch(self, number: int, folder: Path, episodes: int = 3, *, base: str = "test_unseen") -> str:
        """Open an epoch with a tiny split, and return its name; its secret is not what made its data."""
        name, secret = epoch_split_name(base, number), secret_of(number)
        split = tiny.write(folder, name, episodes, hidden=True)
        self.splits[name] = split
        self.board = Board(self.entries, self.splits, steps_per_phase=STEPS, clocks=CLOCKS)
        statement = EpochStatement(
            split=name, base=base, sections=("1",), scale=0.5, episodes=episodes, tried=True, generator="9",
            sources="5" * 64, data_hash=split.data_hash, secret_sha256=secret_digest(secret),
        )  # fmt: skip
        self.epochs.open(name, statement.canonical_json())
        return name

    def participant(self, *names: str) -> None:
        """Create participants with the given names."""
        rows = [{"participant": name, "role": "participant", "created_at": NOON} for name in names]
        with self.database.write() as connection:
            connection.execute(sa.insert(tables.participants), rows)

    def run(
        self,
        run_id: str,
        scores: Sequence[float] | float = 1.0,
        *,
        split: str = "tiny",
        language: str = "en",
        agent: str = "walker",
        participant: str = "lab",
        account: str | None = None,
        sensors: tuple[str, ...] = ("rgb", "depth"),
        steps: int = STEPS,
        clocks: ClockSettings = CLOCKS,
        cause: str = "AGENT_FINISHED",
        causes: Sequence[str] = (),
        over: bool = True,
        code: CodeReference = NO_CODE,
        state: str = COMPLETE,
        arguments: tuple[tuple[str, str], ...] = (),
        thinking: tuple[float, int] = (0.0, 0),
        detour: int = 0,
    ) -> str:
        """Create a run whose episodes have the given scores in all metrics of both turns; one number is for all.

        Another score comes from other actions, and the same one from the same.

        The first ones end by `causes`, all others by `cause`. A `detour` changes actions of the first episode.
        """
        order = [episode.episode_id for episode in self.splits[split].in_playing_order(language)]
        values = [scores] * len(order) if isinstance(scores, float) else list(scores)
        run = Run(
            run_id=run_id, participant=participant, agent=agent, split=split, language=language, sensors=sensors,
            steps_per_phase=steps, data_hash=self.splits[split].data_hash, server_version="9", state=RUNNING,
            created_at=NOON, account=account, agent_arguments=arguments, **asdict(clocks), code=code,
        )  # fmt: skip
        self.journal.create(run, order[: len(values)])
        if over:
            endings = [
                EpisodeEnding(run_id, episode, why, 7, [dict.fromkeys(METRICS, value)] * 2, "", 0, *thinking)
                for episode, value, why in zip(order, values, chain(causes, repeat(cause)), strict=False)
            ]
            batch = CommitBatch(endings=endings)
            for at, (episode, value) in enumerate(zip(order, values, strict=False)):
                digits = np.base_repr(round(value * 10_000), 4) + (at == 0) * detour * "1"
                for step, digit in enumerate(digits):
                    batch.add_step(run_id, episode, 0, step, int(digit))
            self.journal.commit(batch)
            self.journal.set_state(run_id, state)
        return run_id

    def publish(self, run_id: str, note: str = "", caller: Caller = HOST) -> str:
        """Publish a run."""
        self.publisher.publish(caller, run_id, note)
        return run_id


def secret_of(number: int) -> str:
    """Return the secret of a made-up epoch."""
    return f"{number:064x}"


def family(standings: Sequence[Standing], scores: Mapping[str, Sequence[float]]) -> ComparisonFamily:
    """Return the comparisons of the ranked standings, with scores of their episodes by agent."""
    able = [standing for standing in standings if standing.is_ranked]
    values = np.array([scores[standing.agent] for standing in able], ndmin=2)[: len(able)]
    return ComparisonFamily(
        [versions_of_standing(standing) for standing in able], values, np.zeros(values.shape[1], np.intp)
    )


def interval(mean: float, half: float = 0.0) -> Interval:
    """Return the interval of a mean and a half-width."""
    return Interval(mean, mean - half, mean + half)


def standing(
    name: str,
    totals: Mapping[str, Interval],
    *,
    marks: tuple[Mark, ...] = (),
    published: int = 0,
    coverage: float | None = 1.0,
) -> Standing:
    """Return a standing of an agent with these totals and zeros elsewhere, published `minutes` after noon."""
    run = Run(
        run_id=name, participant="lab", agent=name, split="tiny", language="en", sensors=("rgb",),
        steps_per_phase=STEPS, data_hash="0", server_version="9", state=COMPLETE, created_at=NOON, ended_at=NOON,
    )  # fmt: skip
    rows = {row: dict.fromkeys(COLUMNS, interval(0.0)) for row in ROWS}
    rows["total"] = {**rows["total"], **totals}
    published_at = NOON + timedelta(minutes=published)
    progress = RunProgress(episodes=6, ended=6, steps=42, causes={"AGENT_FINISHED": 6})
    return Standing((Entry(run, progress, rows, f"agent:{name}", published_at, "", coverage, marks),), rows)
