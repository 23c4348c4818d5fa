"""Banks, absences, activity and fault counts, with either kind of database."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CLOSER, COMPLETE, RUNNING, Claim, CommitBatch, EpisodeEnding, Run
from arramon_server.runs.storage.run_activity import ABANDONED_SECONDS, UNPLAYED_MINUTES, RunActivity

DATA = "ab" * 32


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    database = Database(database_url)
    yield database
    database.close()


def new_run(database: Database, run_id: str = "r", *, bank: float | None = 100.0) -> Journal:
    created = datetime.now(UTC)
    journal = Journal(database)
    seconds = 0.0 if bank is None else 60.0
    run = Run(
        run_id, "p", "a", "tiny", "en", (), 150, DATA, "0", RUNNING, created, step_seconds=seconds, bank_left=bank
    )
    journal.create(run, ["1", "2"])
    return journal


def test_charges_reduce_the_bank_down_to_zero(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    for charge, left in ((30.0, 70.0), (20.5, 49.5), (49.5, 0.0), (5.0, 0.0)):
        batch = CommitBatch()
        batch.charge("r", charge)
        journal.commit(batch)
        assert activity.bank_left("r") == left
    assert journal.run("r").bank_left == 0.0


def test_charges_of_several_streams_add_up_in_one_commit(database: Database) -> None:
    journal = new_run(database)
    new_run(database, "s", bank=10.0)
    batch = CommitBatch()
    for run_id, seconds in (("r", 1.0), ("s", 2.0), ("r", 3.0), ("s", 0.0)):
        batch.charge(run_id, seconds)
    journal.commit(batch)
    assert [journal.run(run_id).bank_left for run_id in ("r", "s")] == [96.0, 8.0]


def test_faults_are_counted_only_for_the_current_claim(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    for times in (1, 2, 3):
        wanted = journal.open_claims("r") or journal.pending("r", 1)
        (claim,) = journal.claim("r", wanted, "p", "w")
        assert activity.count_fault("r", claim, 3) == times
        assert journal.open_claims("r")[0].worker is None
    assert journal.progress("r").reoffers == 2  # the third time it is not offered again
    (taken,) = journal.claim("r", journal.open_claims("r"), "q", "w")
    assert activity.count_fault("r", claim, 3) == 0
    journal.commit(CommitBatch(endings=[EpisodeEnding("r", "1", "SERVER_FAULT", 0, [{}, {}], fence=taken.fence)]))
    assert activity.count_fault("r", taken, 3) == 0


def test_the_wait_of_a_step_is_kept_until_its_episode_is_released_again(database: Database) -> None:
    journal = new_run(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    for waits, step, waited in (
        ({"1": (4, 12.5)}, 4, 12.5),
        ({}, 4, 12.5),
        ({"1": (4, 14.0)}, 4, 14.0),
        ({"1": (5, None)}, 5, None),
        ({"1": (6, 1.0)}, 6, 1.0),
    ):
        journal.release("r", {"1": claim.fence}, waits)
        (left,) = journal.open_claims("r")
        assert left.seconds_waited(step) == (waited if waited is None else pytest.approx(waited, abs=1.0))
        assert left.seconds_waited(step + 1) is None
        (claim,) = journal.claim("r", [left], "p", "w")


def test_a_step_on_which_the_server_failed_begins_anew(database: Database) -> None:
    journal, activity = new_run(database, bank=1000.0), RunActivity(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    journal.release("r", {"1": claim.fence}, {"1": (0, 500.0)})
    (claim,) = journal.claim("r", journal.open_claims("r"), "p", "w")
    left = activity.bank_left("r")
    activity.count_fault("r", claim, 3)
    live(database, 50.0)
    (claim,) = journal.claim("r", journal.open_claims("r"), "p", "w")
    assert claim.seconds_waited(0) is None
    assert activity.bank_left("r") == left


@pytest.mark.parametrize(("step", "ago", "waited"), [(4, 30.0, 30.0), (4, 5.0, 10.0), (5, 5.0, 5.0), (3, 99.0, 10.0)])
def test_a_process_that_lost_an_episode_can_only_add_to_its_wait(
    database: Database, step: int, ago: float, waited: float
) -> None:
    journal = new_run(database)
    (lost,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    (held,) = journal.claim("r", [lost], "p", "w2")
    journal.release("r", {"1": held.fence}, {"1": (4, 10.0)})
    journal.release("r", {"1": lost.fence}, {"1": (step, ago)})
    (left,) = journal.open_claims("r")
    assert left.seconds_waited(max(step, 4)) == pytest.approx(waited, abs=1.0)


def test_a_claim_counts_as_reoffered_only_if_requested(database: Database) -> None:
    journal = new_run(database)
    claims = journal.claim("r", journal.pending("r"), "p", "w")
    assert journal.progress("r").reoffers == 0
    journal.claim("r", claims, "p", "w", reoffered={"2"})
    assert journal.progress("r").reoffers == 1


def test_abandoned_runs_had_no_stream_for_longer_than_their_bank(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    activity.note_active([])
    live(database, 60.0 + 100.0 + ABANDONED_SECONDS - 5.0)
    assert activity.abandoned([DATA]) is None
    new_run(database, "new")
    activity.note_active([])
    new_run(database, "unnoted")
    live(database, 10.0)
    assert activity.abandoned(["other data"]) is None
    found = activity.abandoned([DATA])
    assert found is not None
    assert found.run_id == "r"
    activity.note_active(["r"])
    assert activity.abandoned([DATA]) is None
    new_run(database, "over")
    activity.note_active([])
    journal.set_state("over", COMPLETE)
    live(database, 150.0)
    assert activity.abandoned([DATA]) is None


@pytest.mark.parametrize("bank", [None, 1e6])
def test_anonymous_runs_that_nobody_begins_to_play_are_abandoned_where_strangers_play(
    database: Database, bank: float | None
) -> None:
    journal, activity = new_run(database, "unplayed", bank=bank), RunActivity(database, close_unplayed=True)
    new_run(database, "played", bank=bank)
    journal.release("played", {claim.episode_id: claim.fence for claim in claim_one(journal, "played", "p")})
    participant = replace(journal.run("unplayed"), run_id="owned", account="ann")
    with database.write() as connection:
        row = {"participant": "ann", "role": "participant", "created_at": participant.created_at}
        connection.execute(tables.participants.insert(), [row])
    journal.create(participant, ["1"])
    activity.note_active([])
    live(database, 60.0 * UNPLAYED_MINUTES - 5.0)
    assert activity.abandoned([DATA]) is None
    live(database, 10.0)
    for _ in range(2):  # also when a part of it has been closed
        found = activity.abandoned([DATA])
        assert found is not None
        assert found.run_id == "unplayed"
        claim_one(journal, "unplayed", CLOSER)
    assert RunActivity(database).abandoned([DATA]) is None
    journal.set_state("unplayed", COMPLETE)
    assert activity.abandoned([DATA]) is None


def claim_one(journal: Journal, run_id: str, player: str) -> list[Claim]:
    return journal.claim(run_id, journal.pending(run_id, 1), player, "w")


def test_absences_are_charged_from_when_the_step_is_overdue_and_each_second_once(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    one, two = journal.claim("r", journal.pending("r"), "p", "w")
    journal.release("r", {"1": one.fence}, {"1": (0, 50.0)})
    journal.release("r", {"2": two.fence}, {"2": (0, 20.0)})
    live(database, 5.0)
    (one,) = journal.claim("r", journal.open_claims("r")[:1], "p", "w")
    assert activity.bank_left("r") == 100.0
    journal.release("r", {"1": one.fence}, {"1": (0, 55.0)})
    live(database, 45.0)
    (two,) = journal.claim("r", journal.open_claims("r")[1:], "p", "w")
    assert activity.bank_left("r") == pytest.approx(60.0, abs=1.0)
    live(database, 5.0)
    journal.claim("r", journal.open_claims("r")[:1], "p", "w")
    assert activity.bank_left("r") == pytest.approx(55.0, abs=1.0)
    live(database, 500.0)
    journal.release("r", {"2": two.fence}, {"2": (0, 580.0)})
    assert activity.bank_left("r") == pytest.approx(55.0, abs=1.0)  # that is for the streams to charge


def test_an_episode_that_was_claimed_and_never_opened_was_absent_all_the_time(database: Database) -> None:
    journal, activity = new_run(database), RunActivity(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    journal.release("r", {"1": claim.fence}, {"1": (0, 60.0)})
    for _ in range(3):
        (claim,) = journal.claim("r", journal.open_claims("r"), "p", "w")
        live(database, 10.0)
        journal.release("r", {"1": claim.fence})
    assert activity.bank_left("r") == pytest.approx(70.0, abs=1.0)


def live(database: Database, seconds: float) -> None:
    """Let time pass, with processes that run all the while."""
    clock = tables.service_clock
    with database.write() as connection:
        connection.execute(clock.update().values(seconds=clock.c.seconds + seconds))
