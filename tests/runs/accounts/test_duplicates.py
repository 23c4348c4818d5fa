"""Runs of different accounts with the same or almost the same actions are found, others are not."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from arramon_server.errors import BadInput
from arramon_server.runs.accounts.duplicates import DuplicatePair, find_duplicates, likeness_of
from arramon_server.runs.storage.records import CommitBatch
from tests.board.leaderboard_backend import LeaderboardBackend

RANDOM = np.random.default_rng(7)
LONG: Sequence[int] = [int(action) for action in RANDOM.integers(0, 3, 60)]


@pytest.fixture
def backend(tmp_path: Path, database_url: str) -> Iterator[LeaderboardBackend]:
    made = LeaderboardBackend(tmp_path, database_url)
    with closing(made.database):
        made.participant("ann", "bob", "cleo")
        yield made


def played(
    backend: LeaderboardBackend, run_id: str, account: str | None, actions: Mapping[str, Sequence[int]], **fields: str
) -> str:
    backend.run(run_id, account=account, participant=account or "lab", over=False, **fields)  # type: ignore[arg-type]
    claims = backend.journal.claim(run_id, backend.journal.pending(run_id), "p", "w")
    batch = CommitBatch()
    for claim in claims:
        for step, action in enumerate(actions.get(claim.episode_id, ())):
            batch.add_step(run_id, claim.episode_id, claim.fence, step, action)
    backend.journal.commit(batch)
    return run_id


def described(pair: DuplicatePair) -> tuple[str, str, int, int, float]:
    return pair.earlier.run_id, pair.later.run_id, pair.episodes, pair.same, round(pair.likeness, 3)


def test_only_runs_of_different_accounts_that_are_alike_are_listed(backend: LeaderboardBackend) -> None:
    whole = {"0": LONG, "1": LONG[::-1]}
    almost = {"0": [*LONG[:57], *(1 - action % 2 for action in LONG[57:])], "1": LONG[::-1]}
    other = {name: [int(action) for action in RANDOM.integers(0, 3, 60)] for name in whole}
    played(backend, "1", "ann", whole)
    played(backend, "2", "bob", whole)
    played(backend, "3", "ann", whole)  # of the same account
    played(backend, "4", "cleo", other)
    played(backend, "5", "cleo", almost)
    played(backend, "6", "bob", whole, split="secret")  # on another split
    found = {described(pair)[:2]: described(pair)[2:] for pair in find_duplicates(backend.database, 0.95)}
    assert found[("1", "2")] == found[("2", "3")] == (2, 2, 1.0)
    assert {pair for pair in found if "5" in pair} == {("1", "5"), ("2", "5"), ("3", "5")}
    assert found[("1", "5")][:2] == (2, 1)
    assert 0.95 <= found[("1", "5")][2] < 1.0
    assert not any("4" in pair or "6" in pair for pair in found)
    assert {described(pair)[:2] for pair in find_duplicates(backend.database, 1.0)} == {("1", "2"), ("2", "3")}
    assert list(find_duplicates(backend.database, 0.0, "secret")) == []


def test_languages_of_a_split_are_compared_and_callers_without_a_token_count_as_one_account(
    backend: LeaderboardBackend,
) -> None:
    played(backend, "1", None, {"1": LONG})
    played(backend, "2", "ann", {"1": LONG}, language="hi")
    played(backend, "3", None, {"1": LONG})
    found = [described(pair)[:2] for pair in find_duplicates(backend.database, 1.0)]
    assert found == [("1", "2"), ("2", "3")]


def test_likeness_needs_enough_common_steps() -> None:
    def actions(*lengths: int) -> dict[str, np.ndarray]:
        return {str(number): np.zeros(length, np.uint8) for number, length in enumerate(lengths)}

    assert likeness_of(actions(30, 19), actions(30, 19)) is None
    assert likeness_of(actions(30, 20), actions(30, 20)) == (2, 2, 1.0)
    assert likeness_of(actions(50), actions(100)) == (1, 0, 0.5)
    assert likeness_of(actions(50), {"x": np.zeros(50, np.uint8)}) is None


@pytest.mark.parametrize("least", [-0.1, 1.1, float("nan")])
def test_likeness_out_of_range_is_refused(backend: LeaderboardBackend, least: float) -> None:
    with pytest.raises(BadInput, match="expected 0 to 1"):
        list(find_duplicates(backend.database, least))
