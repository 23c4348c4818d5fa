"""Leaderboards that close, and show no scores until then."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from arramon_server.board.board import Board
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.publisher import Publisher
from arramon_server.board.standings import Mark
from arramon_server.closing_times import ClosingTimes
from arramon_server.errors import Conflict
from arramon_server.runs.accounts.callers import HOST, READER, Caller, Role
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import SigningKey
from arramon_server.split_times import SplitTimes
from tests import tiny
from tests.board.leaderboard_backend import CLOCKS, STEPS, LeaderboardBackend

CLOSES = datetime(2030, 6, 1, 12, tzinfo=UTC)

ANN = Caller(Role.PARTICIPANT, "ann")


class Season:
    """A board whose split "tiny" closes, with published runs of two participants and one that is not published.

    Attributes:
        now: the present time.
    """

    def __init__(self, backend: LeaderboardBackend, folder: Path, *, frozen: bool) -> None:
        self.backend, self.now = backend, CLOSES - timedelta(seconds=1)
        self.closing = ClosingTimes(SplitTimes((("tiny", CLOSES),)), frozen, lambda: self.now)
        self.receipts = Receipts(backend.database, backend.splits, SigningKey(folder / "key.pem"), self.closing)
        self.publisher = Publisher(backend.journal, backend.splits, backend.entries, self.receipts, self.closing)
        self.board = Board(backend.entries, backend.splits, steps_per_phase=STEPS, clocks=CLOCKS, closing=self.closing)
        backend.participant("ann", "bob")
        for run_id, score in (("good", 1.0), ("poor", 0.125), ("late", 0.5)):
            who = "bob" if run_id == "good" else "ann"
            backend.run(run_id, score, agent=run_id, participant=who, account=who)
        backend.run("other", split="secret")
        for run_id in ("poor", "good", "other"):
            self.publisher.publish(HOST, run_id, "")


@pytest.fixture
def frozen(backend: LeaderboardBackend, tmp_path: Path) -> Season:
    return Season(backend, tmp_path, frozen=True)


@pytest.fixture
def open_(backend: LeaderboardBackend, tmp_path: Path) -> Season:
    return Season(backend, tmp_path, frozen=False)


def test_a_leaderboard_that_closes_shows_scores_unless_it_is_frozen(open_: Season) -> None:
    assert [(one.agent, bool(one.rows)) for one in open_.board.standings("tiny", "en")] == [
        ("good", True), ("poor", True),
    ]  # fmt: skip


def test_no_runs_are_published_after_it_closed(open_: Season) -> None:
    open_.now = CLOSES
    with pytest.raises(Conflict) as error:
        open_.publisher.publish(ANN, "late", "")
    assert str(error.value) == (
        "the leaderboard of split 'tiny' closed on 2030-06-01 at 12:00 UTC: no runs on it are published"
    )
    open_.publisher.publish(ANN, "poor", "a better note")
    assert open_.board.entry("poor").note == "a better note"
    open_.publisher.withdraw(ANN, "poor")
    with pytest.raises(Conflict, match="closed on"):
        open_.publisher.publish(ANN, "poor", "")
    open_.publisher.publish(HOST, "late", "")
    assert len(open_.board.standings("tiny", "en")) == 2


def test_a_frozen_leaderboard_lists_runs_by_time_without_scores_or_ranks(frozen: Season) -> None:
    for sort in ("nDTW", "PTC@CTC-3"):
        listing = frozen.board.listing("tiny", "en", sort)
        assert [(one.agent, one.rank, one.rows) for one in listing.standings] == [("poor", 0, {}), ("good", 0, {})]
        assert listing.frozen
    entry = frozen.board.entry("good")
    assert (entry.frozen, entry.rows, entry.progress.steps, entry.causes) == (True, {}, 0, {})
    assert entry.progress.episodes == 6
    assert frozen.board.entry("other").rows
    rows = list(csv.DictReader(io.StringIO(as_csv(frozen.board.listing("tiny", "en")))))
    assert [(row["agent"], row["rank"], row["PTC@CTC-3"], row["nDTW turn 1"]) for row in rows] == [
        ("poor", "", "", ""), ("good", "", "", ""),
    ]  # fmt: skip
    exported = json.loads(as_json(frozen.board.listing("tiny", "en")))
    assert (exported["frozen"], [one["rows"] for one in exported["standings"]]) == (True, [{}, {}])


@pytest.mark.parametrize(
    ("cause", "mark"), [("FORFEITED", Mark.FORFEITED), ("SERVER_FAULT", Mark.SERVER_FAULT)], ids=["forfeits", "faults"]
)
def test_no_mark_tells_how_episodes_ended_before(
    backend: LeaderboardBackend, tmp_path: Path, cause: str, mark: Mark
) -> None:
    backend.splits["tiny"] = tiny.write(tmp_path, "tiny", 6, hidden=True)
    season = Season(backend, tmp_path, frozen=True)
    backend.run("failed", 0.0, agent="failed", causes=[cause] * 5, participant="ann", account="ann")
    season.publisher.publish(HOST, "failed", "")
    assert season.board.entry("failed").marks == ()
    listing = season.board.listing("tiny", "en")
    assert [one.marks for one in listing.standings] == [(), (), ()]
    season.now = CLOSES
    assert season.board.entry("failed").marks == (mark,)


def epochs_of(season: Season) -> EpochBoard:
    backend = season.backend
    return EpochBoard(season.board, backend.entries, backend.epochs, backend.journal, backend.splits)


REFUSED: dict[str, Callable[[Season], object]] = {
    "compare": lambda season: season.board.compare_with_all("good"),
    "actions": lambda season: epochs_of(season).actions("good"),
    "receipt": lambda season: season.receipts.of(READER, "good"),
    "receipt of another": lambda season: season.receipts.of(ANN, "good"),
}


@pytest.mark.parametrize("call", REFUSED)
def test_what_tells_scores_is_refused_until_it_closes(frozen: Season, call: str) -> None:
    with pytest.raises(Conflict) as error:
        REFUSED[call](frozen)
    assert str(error.value) == (
        "the leaderboard of split 'tiny' is frozen: scores are shown when it closes, on 2030-06-01 at 12:00 UTC"
    )
    frozen.now = CLOSES
    assert REFUSED[call](frozen)


def test_participants_have_their_own_receipts_before(frozen: Season) -> None:
    assert frozen.receipts.of(ANN, "poor")
    assert frozen.receipts.of(HOST, "good")


def test_scores_and_ranks_appear_when_it_closes(frozen: Season) -> None:
    assert not frozen.board.standings("tiny", "en")[0].rows
    frozen.now = CLOSES
    listing = frozen.board.listing("tiny", "en")
    assert not listing.frozen
    assert [one.agent for one in listing.standings] == ["good", "poor"]
    assert all(one.rank for one in listing.standings)
    assert frozen.board.entry("good").causes == {"AGENT_FINISHED": 6}


def test_reproductions_and_epochs_show_no_differences_before(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path, 12) for number in (1, 2))
    backend.participant("ann", "bob")
    for split in (older, newer):
        backend.publish(backend.run(f"on {split}"[:32], 0.5, split=split, account="ann", participant="ann"))
    now = [CLOSES]
    closing = ClosingTimes(SplitTimes(((newer, CLOSES + timedelta(days=1)),)), True, lambda: now[0])
    board = Board(backend.entries, backend.splits, steps_per_phase=STEPS, clocks=CLOCKS, closing=closing)
    epochs = EpochBoard(board, backend.entries, backend.epochs, backend.journal, backend.splits)
    assert list(epochs.changes_between_epochs("en")) == []
    with pytest.raises(Conflict, match=f"the leaderboard of split '{newer}' is frozen"):
        epochs.compare(older, newer, "en")
    assert not replace(closing, frozen=False).is_frozen(newer)
    now[0] = CLOSES + timedelta(days=2)
    assert len(list(epochs.changes_between_epochs("en"))) == 1
