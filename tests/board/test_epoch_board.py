"""Epochs on the leaderboard: states, runs on closed ones, actions, receipts, and the old epoch against the new."""

import json
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from arramon_server.board.corrector import Corrector
from arramon_server.board.standings import BOTH
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.receipts import Receipts, stored_receipt
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.epoch_store import EpochState, check_open
from arramon_server.runs.storage.records import COMPLETE, CodeReference
from arramon_server.scoring.score_changes import EpochScores, score_changes
from tests import tiny
from tests.board.leaderboard_backend import LeaderboardBackend, secret_of


@pytest.fixture
def backend(backend: LeaderboardBackend) -> LeaderboardBackend:
    """A backend with three participants."""
    backend.participant("ann", "bob", "cid")
    return backend


def may_begin(backend: LeaderboardBackend, split: str, data_hash: str = "") -> None:
    """Checks as the creation of a run does."""
    with backend.database.write() as connection:
        check_open(connection, split, data_hash or backend.splits[split].data_hash)


def test_an_epoch_opens_closes_and_is_revealed_in_this_order(backend: LeaderboardBackend, tmp_path: Path) -> None:
    name = backend.epoch(1, tmp_path)
    assert backend.epochs.of(name).state is EpochState.OPEN
    with pytest.raises(Conflict, match="is open; close it first"):
        backend.epochs.reveal(name, secret_of(1))
    with pytest.raises(Conflict, match="there is an epoch 'test_unseen_e1' already"):
        backend.epochs.open(name, b"other")
    backend.epochs.close(name)
    assert (backend.epochs.of(name).state, backend.epochs.of(name).secret) == (EpochState.CLOSED, None)
    with pytest.raises(Conflict, match="was closed on"):
        backend.epochs.close(name)
    backend.epochs.reveal(name, secret_of(1))
    record = backend.epochs.of(name)
    assert (record.state, record.secret) == (EpochState.REVEALED, secret_of(1))
    assert record.closed_at is not None
    assert record.revealed_at is not None
    assert record.opened_at <= record.closed_at <= record.revealed_at
    with pytest.raises(Conflict, match="revealed already"):
        backend.epochs.reveal(name, secret_of(1))
    for method in (backend.epochs.close, backend.epochs.of):
        with pytest.raises(NotFound, match="there is no epoch 'test_unseen_e9'; there are test_unseen_e1"):
            method("test_unseen_e9")


def test_runs_begin_on_open_epochs_with_the_very_data_alone(backend: LeaderboardBackend, tmp_path: Path) -> None:
    name = backend.epoch(1, tmp_path)
    may_begin(backend, "secret")
    may_begin(backend, name)
    with pytest.raises(Conflict, match="is not what the host committed to"):
        may_begin(backend, name, "f" * 64)
    backend.epochs.close(name)
    with pytest.raises(Conflict, match=r"the epoch 'test_unseen_e1' was closed on .* UTC, and no runs begin on it"):
        may_begin(backend, name)
    backend.epochs.reveal(name, secret_of(1))
    with pytest.raises(Conflict, match="no runs begin on it"):
        may_begin(backend, name)


def test_runs_that_were_begun_are_finished_and_published_before_the_secret_is_out(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    name = backend.epoch(1, tmp_path)
    backend.run("1", split=name, over=False)
    assert backend.epochs.close(name) == ["1"]
    with pytest.raises(Conflict, match=r"1 runs on the epoch 'test_unseen_e1' are still being played: 1; wait"):
        backend.epochs.reveal(name, secret_of(1))
    backend.journal.set_state("1", COMPLETE)
    backend.run("2", split=name)
    backend.epochs.reveal(name, secret_of(1))
    backend.publish("2")
    assert [line.rank for line in backend.board.standings(name, "en")] == [1]


def test_receipts_hold_the_commitment(backend: LeaderboardBackend, tmp_path: Path) -> None:
    name = backend.epoch(1, tmp_path)
    backend.publish(backend.run("1", split=name))
    backend.publish(backend.run("2", split="secret"))
    found = {}
    for run_id in ("1", "2"):
        receipt = stored_receipt(backend.database, run_id)
        assert receipt is not None
        found[run_id] = json.loads(receipt.payload).get("epoch")
    assert found == {"1": backend.epochs.of(name).commitment.hex(), "2": None}


def test_actions_are_public_on_open_splits_and_revealed_epochs_alone(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    name = backend.epoch(1, tmp_path)
    for run_id, split in (("1", "tiny"), ("2", "secret"), ("3", name)):
        backend.publish(backend.run(run_id, split=split))
    backend.run("4", split="tiny")
    assert set(backend.epoch_board.actions("1")) == set(backend.splits["tiny"].episodes)
    for run_id in ("2", "3"):
        with pytest.raises(Conflict, match="is hidden: its runs' actions are public only once the secret"):
            backend.epoch_board.actions(run_id)
    with pytest.raises(NotFound):
        backend.epoch_board.actions("4")
    backend.epochs.close(name)
    with pytest.raises(Conflict, match="is hidden"):
        backend.epoch_board.actions("3")
    backend.epochs.reveal(name, secret_of(1))
    assert set(backend.epoch_board.actions("3")) == set(backend.splits[name].episodes)
    backend.publisher.withdraw(HOST, "3")
    with pytest.raises(NotFound):
        backend.epoch_board.actions("3")


def test_agents_stand_on_the_old_epoch_against_the_new(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path, 240) for number in (1, 2))
    of = {older: {"learned": 1.0, "honest": 0.5, "once": 1.0}, newer: {"learned": 0.25, "honest": 0.5}}
    for split, agents in of.items():
        for agent, score in agents.items():
            run_id = f"{agent} {split}"
            backend.publish(backend.run(run_id, score, agent=agent, split=split, account="ann", participant="ann"))
    found = backend.epoch_board.compare(older, newer, "en")
    lines = {line.newer.agent: line for line in found.agents}
    assert list(lines) == ["learned", "honest"]  # the greatest fall first
    learned, honest = lines["learned"], lines["honest"]
    assert (learned.older_mean, learned.newer_mean) == pytest.approx((1.0, 0.25), abs=0.05)
    assert learned.difference.mean == pytest.approx(learned.newer_mean - learned.older_mean, abs=1e-4)
    assert honest.difference.mean == pytest.approx(0.0, abs=0.05)
    assert learned.difference.high < 0.0 < honest.difference.high
    assert learned.against_others is not None
    assert honest.against_others is not None
    apart = learned.difference.mean - honest.difference.mean
    assert (learned.against_others.mean, honest.against_others.mean) == pytest.approx((apart, -apart), abs=1e-3)
    assert found.mean is not None
    assert found.mean.mean == pytest.approx((learned.difference.mean + honest.difference.mean) / 2, abs=1e-3)
    assert [(pair.older, pair.newer) for pair in backend.epoch_board.changes_between_epochs("en")] == [(older, newer)]
    assert list(backend.epoch_board.changes_between_epochs("hi")) == []


def test_changes_are_those_of_the_episodes_that_are_not_void(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path, 60) for number in (1, 2))
    for split, score in ((older, 0.0), (newer, 0.5)):
        backend.publish(backend.run(f"on {split}", score, split=split, account="ann", participant="ann"))
    first = backend.splits[newer].in_playing_order("en")[0].episode_id
    Corrector(backend.database, backend.splits, SigningKey(tmp_path / "key.pem")).void(newer, [first], "a wall")
    (line,) = backend.epoch_board.compare(older, newer, "en").agents
    means = (line.older_mean, line.newer_mean)
    scored = [EpochScores([mean], [1], episodes) for mean, episodes in zip(means, (60, 59), strict=True)]
    assert line.difference == score_changes(*scored).of_each[0]
    assert line.difference != score_changes(*(replace(one, episodes=60) for one in scored)).of_each[0]


def test_only_the_same_agents_are_compared(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path) for number in (1, 2))
    one, other = CodeReference("https://example.org/a", "a" * 40), CodeReference("https://example.org/a", "b" * 40)

    def publish(
        name: str, account: str, codes: tuple[CodeReference, CodeReference], sensors: tuple[str, ...] = ("rgb",)
    ) -> None:
        for split, code in zip((older, newer), codes, strict=True):
            run = partial(backend.run, agent=name, account=account, participant=account, code=code)
            backend.publish(run(f"{name[:5]} {split[-2:]}", split=split, sensors=sensors))

    publish("same code", "ann", (one, one))
    publish("other code", "ann", (one, other))
    publish("half named", "bob", (one, CodeReference()))
    publish("privileged", "bob", (one, one), ("rgb", "oracle"))
    backend.publish(backend.run("x", agent="mine", account="cid", participant="cid", split=older))
    backend.publish(backend.run("y", agent="mine", account="bob", participant="bob", split=newer))
    found = {line.newer.agent: line.same_code for line in backend.epoch_board.compare(older, newer, "en").agents}
    assert found == {"same code": True, "half named": False}


def test_of_several_runs_the_one_published_last_counts(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path) for number in (1, 2))
    for run_id, split, score in (("1", older, 1.0), ("2", older, 0.0), ("3", newer, 0.5)):
        backend.publish(backend.run(run_id, score, split=split))
    (line,) = backend.epoch_board.compare(older, newer, "en").agents
    assert (line.older.entries[0].run.run_id, line.against_others) == ("2", None)
    assert line.difference.mean == pytest.approx(line.newer_mean - line.older_mean, abs=1e-4)


@pytest.mark.parametrize(
    ("older", "newer", "language", "metric", "error", "problem"),
    [
        ("test_unseen_e2", "test_unseen_e1", "en", "nDTW", BadInput, "the older one first"),
        ("test_unseen_e1", "test_unseen_e1", "en", "nDTW", BadInput, "the older one first"),
        ("test_unseen_e1", "other_e2", "en", "nDTW", BadInput, "two epochs of one split"),
        ("test_unseen_e1", "test_unseen_e3", "en", "nDTW", NotFound, "there is no epoch 'test_unseen_e3'; there are"),
        ("tiny", "test_unseen_e1", "en", "nDTW", NotFound, "there is no epoch 'tiny'"),
        ("test_unseen_e1", "test_unseen_e2", "xx", "nDTW", NotFound, "has no language 'xx'"),
        ("test_unseen_e1", "test_unseen_e2", BOTH, "nDTW", BadInput, "in one language"),
        ("test_unseen_e1", "test_unseen_e2", "en", "best", BadInput, "cannot compare 'best'"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    backend: LeaderboardBackend,
    tmp_path: Path,
    older: str,
    newer: str,
    language: str,
    metric: str,
    error: type[Exception],
    problem: str,
) -> None:
    for number, base in ((1, "test_unseen"), (2, "test_unseen"), (2, "other")):
        backend.epoch(number, tmp_path, base=base)
    with pytest.raises(error, match=problem):
        backend.epoch_board.compare(older, newer, language, metric)


def test_without_agents_on_both_there_is_nothing_to_compare(backend: LeaderboardBackend, tmp_path: Path) -> None:
    older, newer = (backend.epoch(number, tmp_path) for number in (1, 2))
    found = backend.epoch_board.compare(older, newer, "en")
    assert (found.agents, found.mean) == ((), None)


def test_a_stored_receipt_of_an_epoch_is_rescored_with_its_commitment(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    """The field is no part of what is derived again, and makes no difference."""
    from arramon_server.runs.results.rescoring import Rescorer
    from tests.played import play

    name = backend.epoch(1, tmp_path)
    play(backend.database, backend.splits[name], actions=dict.fromkeys("012", tiny.ACTIONS))
    Receipts(backend.database, backend.splits, SigningKey(tmp_path / "key.pem")).of(HOST, "r")
    with closing(Rescorer(backend.database, backend.splits)) as rescorer:
        assert rescorer.rescore("r").differences == ()
