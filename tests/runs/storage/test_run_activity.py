"""Banks, absences, activity and fault counts, with either kind of database."""

from collections.abc import Iterator
from datetime import UTC, datetime

import pytest

from server.runs.storage.database import Database
from server.runs.storage.journal import Journal
from server.runs.storage.records import AWAY_SECONDS, COMPLETE, RUNNING, Batch, Ending, Run
from server.runs.storage.run_activity import EXCUSE_SECONDS, RunActivity

DATA = "ab" * 32


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    database = Database(database_url)
    yield database
    database.close()


def new_run(database: Database, run_id: str = "r", *, age: float = 0.0, bank: float = 100.0) -> Journal:
    created = datetime.fromtimestamp(datetime.now(UTC).timestamp() - age, UTC)
    journal = Journal(database)
    run = Run(run_id, "p", "a", "tiny", "en", (), 150, DATA, "0", RUNNING, created, bank_left=bank)
    journal.create(run, ["1", "2"])
    return journal


def test_a_bank_loses_what_is_charged_and_never_more_than_it_holds(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    for charge, left in ((30.0, 70.0), (20.5, 49.5), (49.5, 0.0), (5.0, 0.0)):
        batch = Batch()
        batch.charge("r", charge)
        journal.commit(batch)
        assert activity.bank_left("r") == left
    assert journal.run("r").bank_left == 0.0


def test_charges_of_several_streams_add_up_in_one_commit(database: Database) -> None:
    journal = new_run(database)
    new_run(database, "s", bank=10.0)
    batch = Batch()
    for run_id, seconds in (("r", 1.0), ("s", 2.0), ("r", 3.0), ("s", 0.0)):
        batch.charge(run_id, seconds)
    journal.commit(batch)
    assert [journal.run(run_id).bank_left for run_id in ("r", "s")] == [96.0, 8.0]


def test_a_run_has_steps_when_one_was_answered(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    assert not activity.has_steps("r")
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    batch = Batch()
    batch.add_step("r", "1", claim.epoch, 0, 3)
    journal.commit(batch)
    assert activity.has_steps("r")


def test_faults_are_counted_under_the_claim_that_is_held(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    for times in (1, 2, 3):
        wanted = journal.open_claims("r") or journal.pending("r", 1)
        (claim,) = journal.claim("r", wanted, "p", "w")
        assert activity.count_fault("r", claim, 3) == times
        assert journal.open_claims("r")[0].worker is None
    assert journal.progress("r").reoffers == 2  # the third time it is not offered again
    (taken,) = journal.claim("r", journal.open_claims("r"), "q", "w")
    assert activity.count_fault("r", claim, 3) == 0
    journal.commit(Batch(endings=[Ending("r", "1", "SERVER_FAULT", 0, [{}, {}], epoch=taken.epoch)]))
    assert activity.count_fault("r", taken, 3) == 0


def test_the_wait_of_a_step_is_kept_until_the_next_stream_has_it(database: Database) -> None:
    journal = new_run(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    journal.release("r", {"1": claim.epoch}, waited={"1": 12.5})
    (left,) = journal.open_claims("r")
    assert left.waited == 12.5
    (again,) = journal.claim("r", [left], "p", "w")
    assert again.waited == 12.5
    assert journal.open_claims("r")[0].waited == 0.0


def test_a_claim_counts_as_reoffered_only_if_requested(database: Database) -> None:
    journal = new_run(database)
    claims = journal.claim("r", journal.pending("r"), "p", "w")
    assert journal.progress("r").reoffers == 0
    journal.claim("r", claims, "p", "w", reoffered={"2"})
    assert journal.progress("r").reoffers == 1


def test_idle_runs_were_neither_created_nor_played_recently(database: Database) -> None:
    journal, activity = new_run(database, age=1000.0), RunActivity(database)
    new_run(database, "new")
    assert activity.idle(2000.0, [DATA]) is None
    assert activity.idle(900.0, ["other data"]) is None
    found = activity.idle(900.0, [DATA])
    assert found is not None
    assert found.run_id == "r"
    activity.note_active(["r", "new"])
    assert activity.idle(900.0, [DATA]) is None
    new_run(database, "over", age=1000.0)
    journal.set_state("over", COMPLETE)
    assert activity.idle(900.0, [DATA]) is None


def test_idle_runs_are_excused_after_a_downtime(database: Database) -> None:
    week = 7 * EXCUSE_SECONDS
    journal, activity = new_run(database, age=2 * week), RunActivity(database)
    journal.beat("living")
    activity.excuse_idle(week)
    assert activity.idle(week, [DATA]) is not None
    journal.retire("living")
    activity.excuse_idle(week)
    assert activity.idle(week, [DATA]) is None
    assert activity.idle(week - EXCUSE_SECONDS - 60.0, [DATA]) is not None


def test_simultaneous_absences_of_several_streams_count_once(database: Database) -> None:
    new_run(database)
    activity = RunActivity(database)
    assert activity.away_left("r") == AWAY_SECONDS
    assert activity.add_absence("r", 100.0) == pytest.approx(AWAY_SECONDS - 100.0, abs=1.0)
    assert activity.add_absence("r", 80.0) == pytest.approx(AWAY_SECONDS - 100.0, abs=5.0)
    assert activity.add_absence("r", AWAY_SECONDS + 100.0) == pytest.approx(AWAY_SECONDS - 100.0, abs=5.0)
