"""Notes in the journal: with their steps or not at all, counted by run, and listed by episode and step."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_server.errors import TakenOver
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CommitBatch, StepNote
from tests.runs.storage.test_journal import a_run, steps


@pytest.fixture
def journal(database_url: str) -> Iterator[Journal]:
    """Return a journal with two runs of two episodes."""
    with closing(Database(database_url)) as database:
        journal = Journal(database)
        for run_id in ("r", "s"):
            journal.create(a_run(run_id), ["b", "a"])
        yield journal


def noted(run_id: str, episode_id: str, *notes: str, first: int = 0) -> CommitBatch:
    """A batch of steps with notes, where these are not empty."""
    batch = steps(run_id, episode_id, *(0 for _ in notes), first=first)
    for step, note in enumerate(notes, start=first):
        if note:
            batch.add_note(run_id, episode_id, step, note)
    return batch


def test_notes_are_read_back_and_their_sizes_counted(journal: Journal) -> None:
    journal.commit(noted("r", "a", "left", "", "दाएँ"))
    journal.commit(noted("r", "b", "up"))
    assert journal.actions("r", "a") == [0, 0, 0]
    assert journal.notes_of("r", "a") == {0: "left", 2: "दाएँ"}
    assert journal.notes_of("s", "a") == {}
    assert (journal.notes_size("r"), journal.notes_size("s")) == (4 + 12 + 2, 0)
    assert journal.notes_size("nowhere") == 0


def test_one_commit_has_notes_of_several_runs_and_charges(journal: Journal) -> None:
    batch = noted("s", "b", "two")
    for part in (noted("r", "a", "one", "more"), noted("r", "b", "x")):
        batch.steps += part.steps
        batch.notes += part.notes
    batch.charge("r", 1.5)
    journal.commit(batch)
    assert [journal.notes_size(run_id) for run_id in ("r", "s")] == [8, 3]
    assert journal.notes_of("s", "b") == {0: "two"}


@pytest.mark.parametrize("ends", [False, True])
def test_a_step_that_is_not_written_has_no_note(journal: Journal, ends: bool) -> None:
    journal.commit(noted("r", "a", "first"))
    batch = noted("r", "a", "second")
    other = noted("r", "b", "other")
    batch.steps += other.steps
    batch.notes += other.notes
    if ends:
        batch.charge("r", 1.0)
    with pytest.raises(TakenOver):
        journal.commit(batch)
    assert (journal.notes_of("r", "a"), journal.notes_of("r", "b"), journal.notes_size("r")) == ({0: "first"}, {}, 5)
    journal.commit(batch.without({("r", "a")}))
    assert (journal.notes_of("r", "b"), journal.notes_size("r")) == ({0: "other"}, 10)


def test_pages_go_on_after_the_last_note(journal: Journal) -> None:
    journal.commit(noted("r", "b", "b0", "b1"))
    journal.commit(noted("r", "a", "a0", "", "a2"))
    journal.commit(noted("s", "a", "another run's"))
    everything = [StepNote("a", 0, "a0"), StepNote("a", 2, "a2"), StepNote("b", 0, "b0"), StepNote("b", 1, "b1")]
    assert journal.note_page("r", 9) == everything
    assert journal.note_page("r", 2) == everything[:2]
    assert journal.note_page("r", 9, last=("a", 2)) == everything[2:]
    assert journal.note_page("r", 9, last=("a", 1)) == everything[1:]
    assert journal.note_page("r", 9, episode_id="b") == everything[2:]
    assert journal.note_page("r", 9, episode_id="b", last=("b", 0)) == everything[3:]
    assert [journal.has_episode("r", name) for name in ("a", "c")] == [True, False]
