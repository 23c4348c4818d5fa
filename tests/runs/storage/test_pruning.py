"""Pruning deletes old unpublished runs with all their rows, and keeps them in the numbers of attempts."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from arramon_server.board.corrector import Corrector
from arramon_server.errors import BadInput, NotFound
from arramon_server.runs.accounts.attempts import attempt_number, attempts_on
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.accounts.usage import usage_of
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.corrections import Corrections
from arramon_server.runs.storage.pruning import PruneFilter, Pruner
from arramon_server.runs.storage.records import CANCELLED, RUNNING, CommitBatch
from arramon_server.runs.transfer.export import export
from arramon_server.runs.transfer.restore import import_archive
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.postgres import await_lock

NOW = datetime.now(UTC)


@pytest.fixture
def backend(tmp_path: Path, database_url: str) -> Iterator[LeaderboardBackend]:
    made = LeaderboardBackend(tmp_path, database_url)
    with closing(made.database):
        made.participant("ann", "bob")
        yield made


def age(backend: LeaderboardBackend, run_id: str, days: float) -> str:
    """Lets a run have been created and have ended so many days ago."""
    at = NOW - timedelta(days=days)
    c = tables.runs.c
    ended = sa.case((c.state == "RUNNING", sa.null()), else_=sa.literal(at, c.created_at.type))
    with backend.database.write() as connection:
        connection.execute(tables.runs.update().where(c.run_id == run_id).values(created_at=at, ended_at=ended))
    return run_id


def pruned(backend: LeaderboardBackend, days: float = 30, **fields: object) -> list[str]:
    """Prunes, and checks that a dry run would have said the same."""
    wanted = PruneFilter(days, **fields)  # type: ignore[arg-type]
    found = [each.run.run_id for each in Pruner(backend.database).find(wanted)]
    assert [each.run.run_id for each in Pruner(backend.database).prune(wanted)] == found
    return found


def rows_of(backend: LeaderboardBackend, run_id: str) -> dict[str, int]:
    """The number of rows that name a run, by table, without those that have none."""
    tables_ = [table for table in tables.metadata.sorted_tables if "run_id" in table.c]
    counts = {table.name: sa.select(sa.func.count()).where(table.c.run_id == run_id) for table in tables_}
    found = {name: int(backend.database.read(count)[0][0]) for name, count in counts.items()}
    return {name: number for name, number in found.items() if number}


def test_old_unpublished_runs_are_deleted_with_all_their_rows(backend: LeaderboardBackend) -> None:
    old = age(backend, backend.run("1" * 32, account="ann"), 40)
    backend.journal.create(replace(backend.journal.run(old), run_id="2" * 32, state=RUNNING, ended_at=None), ["0"])
    backend.journal.record_image_format("2" * 32, "lossless-224")
    (claim,) = backend.journal.claim("2" * 32, backend.journal.pending("2" * 32), "p", "w")
    batch = CommitBatch()
    batch.add_step("2" * 32, "0", claim.fence, 0, 1)
    batch.add_note("2" * 32, "0", 0, "to the mug")
    backend.journal.commit(batch)
    backend.journal.set_state("2" * 32, CANCELLED)
    age(backend, "2" * 32, 35)
    kept = age(backend, backend.run("3" * 32, account="ann"), 29)
    assert set(rows_of(backend, "2" * 32)) == {"runs", "run_episodes", "run_images", "steps", "step_notes"}
    assert pruned(backend) == [old, "2" * 32]
    assert rows_of(backend, old) == rows_of(backend, "2" * 32) == {"pruned_runs": 1}
    assert backend.journal.run(kept).run_id == kept
    with pytest.raises(NotFound):
        backend.journal.run(old)
    assert pruned(backend) == []


def test_runs_that_are_or_were_published_and_unfinished_ones_are_kept(backend: LeaderboardBackend) -> None:
    listed = age(backend, backend.publish(backend.run("1")), 400)
    withdrawn = age(backend, backend.publish(backend.run("2")), 400)
    backend.publisher.withdraw(HOST, withdrawn)
    running = age(backend, backend.run("3", over=False), 400)
    assert pruned(backend, with_receipts=True) == []
    assert {listed, withdrawn, running} <= {run.run_id for run in backend.journal.runs(9)}


def test_runs_with_receipts_are_pruned_only_on_request(backend: LeaderboardBackend) -> None:
    run_id = age(backend, backend.run("1"), 400)
    backend.publisher._receipts.of(HOST, run_id)
    assert pruned(backend) == []
    assert pruned(backend, with_receipts=True) == [run_id]
    assert rows_of(backend, run_id) == {"pruned_runs": 1}


def test_superseded_receipts_are_pruned_with_their_runs(backend: LeaderboardBackend, tmp_path: Path) -> None:
    run_id = age(backend, backend.run("1"), 400)
    backend.publisher._receipts.of(HOST, run_id)
    corrector = Corrector(backend.database, backend.splits, SigningKey(tmp_path / "key.pem"))
    correction = corrector.void("tiny", ["0"], "a wall in the way")
    assert corrector.renew_receipts("tiny") == 1
    with backend.database.write() as connection:
        Corrections(backend.database).note_rescored(connection, run_id, correction)
    assert {"receipts", "superseded_receipts", "rescored_runs"} <= set(rows_of(backend, run_id))
    assert pruned(backend) == []
    assert pruned(backend, with_receipts=True) == [run_id]
    assert rows_of(backend, run_id) == {"pruned_runs": 1}


def test_state_split_and_participant_choose(backend: LeaderboardBackend) -> None:
    for run_id, fields in {
        "1": {}, "2": {"state": CANCELLED}, "3": {"split": "secret"}, "4": {"participant": "club"},
    }.items():  # fmt: skip
        age(backend, backend.run(run_id, **fields), 40)  # type: ignore[arg-type]
    assert pruned(backend, states=(CANCELLED,)) == ["2"]
    assert pruned(backend, split="secret") == ["3"]
    assert pruned(backend, participant="club") == ["4"]
    assert pruned(backend) == ["1"]


def test_pruned_runs_still_count_as_attempts_and_for_the_limit_in_total(backend: LeaderboardBackend) -> None:
    read = backend.database.read
    for number in range(1, 6):
        age(backend, backend.run(str(number), account="ann", participant="ann"), 50 - number)
    age(backend, backend.run("f", account="ann", participant="ann", cause="SERVER_FAULT"), 40)
    for number in (6, 7):
        age(backend, backend.run(str(number), account=None, participant="lab"), 50 - number)
    age(backend, backend.run("8", account="ann", participant="ann"), 2)
    backend.publish("8")

    def numbers() -> tuple[object, ...]:
        counted = backend.board.standings("tiny", "en")[0].attempts
        last = backend.journal.run("8")
        return attempts_on(read, "tiny"), attempt_number(read, last), usage_of(read, "ann", "tiny"), counted

    before = numbers()
    assert before[1] == (7, 7)
    assert pruned(backend) == ["1", "2", "3", "4", "5", "6", "7", "f"]
    assert numbers() == before
    backend.run("9", account="ann", participant="ann")
    assert backend.board.standings("tiny", "en")[0].attempts.begun == 8  # the board notices a new run after a pruning


def test_a_run_that_is_published_meanwhile_is_kept(backend: LeaderboardBackend) -> None:
    first, second = (age(backend, backend.run(name), 40) for name in "12")
    pruning = Pruner(backend.database).prune(PruneFilter(30))
    assert next(pruning).run.run_id == first
    backend.publish(second)
    assert list(pruning) == []
    assert backend.journal.run(second).run_id == second


def test_a_run_is_kept_whose_publication_the_pruning_waits_for(postgres_url: str, tmp_path: Path) -> None:
    backend = LeaderboardBackend(tmp_path, postgres_url)
    with closing(backend.database), ThreadPoolExecutor(1) as pool:
        run_id = age(backend, backend.run("1"), 40)
        with backend.database.write() as connection:
            entry = {"run_id": run_id, "published_at": NOW, "note": "", "scores": {}}
            connection.execute(tables.entries.insert(), [entry])
            pruning = pool.submit(lambda: list(Pruner(backend.database).prune(PruneFilter(30))))
            await_lock(postgres_url, pruning)
        assert pruning.result() == []
        assert backend.journal.run(run_id).run_id == run_id


def test_a_pruned_run_that_is_imported_again_counts_once_and_can_be_pruned_again(
    backend: LeaderboardBackend, tmp_path: Path
) -> None:
    run_id = age(backend, backend.run("1", account="ann", participant="ann"), 40)
    export(backend.database, tmp_path / "before")
    assert pruned(backend) == [run_id]
    export(backend.database, tmp_path / "after")
    for backup in ("before", "after"):
        import_archive(backend.database, tmp_path / backup, merge=True)
        assert "pruned_runs" not in rows_of(backend, run_id)
        assert attempt_number(backend.database.read, backend.journal.run(run_id)) == (1, 1)
    assert pruned(backend) == [run_id]
    assert rows_of(backend, run_id) == {"pruned_runs": 1}


def test_space_is_freed(backend: LeaderboardBackend, tmp_path: Path) -> None:
    run = backend.journal.run(backend.run("1", over=False))
    (claim,) = backend.journal.claim("1", backend.journal.pending("1")[:1], "p", "w")
    for start in range(0, 40_000, 5_000):
        batch = CommitBatch()
        for step in range(start, start + 5_000):
            batch.add_step("1", claim.episode_id, claim.fence, step, 0)
        backend.journal.commit(batch)
    backend.journal.set_state(run.run_id, CANCELLED)
    age(backend, "1", 40)
    file = tmp_path / "journal.db"
    Pruner(backend.database).compact()
    large = file.stat().st_size if backend.database.is_file else 0
    assert [(each.run.run_id, each.steps) for each in Pruner(backend.database).prune(PruneFilter(30))] == [
        ("1", 40_000)
    ]
    Pruner(backend.database).compact()
    if backend.database.is_file:
        assert file.stat().st_size < large / 2
    assert backend.database.read(sa.select(sa.func.count()).select_from(tables.steps))[0][0] == 0


@pytest.mark.parametrize("days", [0, 0.9, -1, 36_501, float("nan")])
def test_younger_runs_cannot_be_pruned(days: float) -> None:
    """They count for the limits of a day."""
    with pytest.raises(BadInput, match="expected 1 to 36500"):
        PruneFilter(days)
