"""Conditions of publication and withdrawal, with every kind of database."""

from contextlib import closing
from pathlib import Path

import pytest

from arramon_server.board.entries import PublishedRun
from arramon_server.errors import ArraMonError, BadInput, Conflict, Forbidden, NotFound
from arramon_server.runs.accounts.administration import Administration
from arramon_server.runs.accounts.callers import ANONYMOUS, HOST, UNAUTHENTICATED, Caller, Role
from arramon_server.runs.storage import tables
from tests.board.leaderboard_backend import LeaderboardBackend

ANN, BOB = Caller(Role.PARTICIPANT, "ann"), Caller(Role.PARTICIPANT, "bob")


@pytest.fixture
def runs(backend: LeaderboardBackend) -> LeaderboardBackend:
    """Create a run of ann, and an anonymous one."""
    backend.participant("ann", "bob")
    backend.run("anns", account="ann", participant="ann")
    backend.run("nobodys")
    return backend


def listed(backend: LeaderboardBackend) -> list[str]:
    return sorted(line.entries[0].run.run_id for line in backend.board.standings("tiny", "en"))


@pytest.mark.parametrize(
    ("caller", "run_id", "error"),
    [
        (ANN, "anns", None),
        (HOST, "anns", None),
        (BOB, "anns", NotFound),
        (ANONYMOUS, "anns", NotFound),
        (UNAUTHENTICATED, "anns", Forbidden),
        (ANONYMOUS, "nobodys", None),
        (HOST, "nobodys", None),
        (ANN, "nobodys", NotFound),
        (UNAUTHENTICATED, "nobodys", Forbidden),
        (HOST, "missing", NotFound),
        (ANN, "missing", NotFound),
    ],
)
def test_publishing_and_withdrawing_depend_on_caller_and_run(
    runs: LeaderboardBackend, caller: Caller, run_id: str, error: type[ArraMonError] | None
) -> None:
    if error is None:
        runs.publish(run_id, caller=caller)
        assert listed(runs) == [run_id]
        runs.publisher.withdraw(caller, run_id)
        assert listed(runs) == []
        return
    with pytest.raises(error):
        runs.publish(run_id, caller=caller)
    assert listed(runs) == []
    if run_id != "missing":
        runs.publish(run_id)
    with pytest.raises(error):
        runs.publisher.withdraw(caller, run_id)
    assert listed(runs) == ([run_id] if run_id != "missing" else [])


def test_missing_runs_and_those_of_others_give_the_same_error(runs: LeaderboardBackend) -> None:
    said = []
    for run_id in ("anns", "missing"):
        with pytest.raises(NotFound) as caught:
            runs.publish(run_id, caller=BOB)
        said.append(str(caught.value).replace(run_id, "X"))
    assert said == ["there is no run 'X'"] * 2


def test_withdrawn_run_can_be_published_again(runs: LeaderboardBackend) -> None:
    runs.publish("anns", "first", ANN)
    first = runs.board.entry("anns").published_at
    runs.publisher.withdraw(ANN, "anns")
    entry = runs.entries.find("anns")
    assert entry is not None
    assert entry.withdrawn_at is not None
    runs.publish("anns", "second", ANN)
    assert runs.board.entry("anns").note == "second"
    assert runs.board.entry("anns").published_at > first


def test_republishing_changes_only_the_note(runs: LeaderboardBackend) -> None:
    runs.publish("anns", "first", ANN)
    before = runs.board.entry("anns")
    runs.publish("anns", " second ", ANN)
    after = runs.board.entry("anns")
    assert (after.note, after.published_at) == ("second", before.published_at)


def test_only_the_host_republishes_what_the_host_withdrew(runs: LeaderboardBackend) -> None:
    runs.publish("anns", caller=ANN)
    runs.publisher.withdraw(HOST, "anns")
    with pytest.raises(Forbidden, match="the host has withdrawn run 'anns'; only the host can publish it again"):
        runs.publish("anns", caller=ANN)
    runs.publish("anns", caller=HOST)
    runs.publisher.withdraw(ANN, "anns")
    runs.publish("anns", caller=ANN)
    assert listed(runs) == ["anns"]


def test_concurrent_publication_does_not_undo_the_hosts_withdrawal(
    runs: LeaderboardBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs.publish("anns", caller=ANN)
    find = runs.entries.find

    def found_just_before(run_id: str) -> PublishedRun | None:
        entry = find(run_id)
        monkeypatch.setattr(runs.entries, "find", find)
        runs.publisher.withdraw(HOST, run_id)
        return entry

    monkeypatch.setattr(runs.entries, "find", found_just_before)
    with pytest.raises(Forbidden, match="the host has withdrawn run 'anns'"):
        runs.publish("anns", caller=ANN)
    assert listed(runs) == []


def test_host_withdrawal_also_applies_to_an_already_withdrawn_run(runs: LeaderboardBackend) -> None:
    runs.publish("anns", caller=ANN)
    runs.publisher.withdraw(ANN, "anns")
    runs.publisher.withdraw(HOST, "anns")
    with pytest.raises(Forbidden):
        runs.publish("anns", caller=ANN)
    runs.publisher.withdraw(HOST, "anns")  # once more changes nothing
    assert listed(runs) == []


def test_what_the_host_withdraws_after_a_ban_stays_withdrawn_when_it_ends(runs: LeaderboardBackend) -> None:
    runs.publish("anns", caller=ANN)
    runs.publish(runs.run("another", account="ann", participant="ann", agent="another"), caller=ANN)
    administration = Administration(runs.database)
    administration.ban("ann", "spam")
    runs.publisher.withdraw(HOST, "anns")
    assert administration.unban("ann") == 1
    assert listed(runs) == ["another"]
    with pytest.raises(Forbidden, match="the host has withdrawn run 'anns'"):
        runs.publish("anns", caller=ANN)


def test_a_run_that_was_never_published_cannot_be_withdrawn_by_the_host(runs: LeaderboardBackend) -> None:
    with pytest.raises(NotFound, match="run 'anns' is not on the leaderboard"):
        runs.publisher.withdraw(HOST, "anns")


@pytest.mark.parametrize("split", ["secret", "tiny"])
def test_a_run_without_one_finished_episode_is_not_published(backend: LeaderboardBackend, split: str) -> None:
    backend.run("cancelled", 0.0, split=split, cause="FORFEITED")
    number = backend.journal.progress("cancelled").episodes
    with pytest.raises(
        Conflict, match=f"no episode that was played to its end.* causes of its episodes: {number} FORFEITED$"
    ):
        backend.publish("cancelled")
    assert backend.board.listing(split, "en").standings == ()


@pytest.mark.parametrize("cause", ["AGENT_FINISHED", "STEP_LIMIT", "TIME_LIMIT"])
def test_a_cancelled_run_with_a_finished_episode_is_published(backend: LeaderboardBackend, cause: str) -> None:
    backend.run("part", 0.0, split="secret", cause="FORFEITED")
    c = tables.episodes.c
    with backend.database.write() as connection:
        first = (c.run_id == "part") & (c.ordinal == 0)
        connection.execute(tables.episodes.update().where(first).values(cause=cause))
    backend.publish("part")
    assert len(backend.board.listing("secret", "en").standings) == 1


def test_unlisted_runs_cannot_be_withdrawn(runs: LeaderboardBackend) -> None:
    for _ in range(2):
        with pytest.raises(NotFound, match="run 'anns' is not on the leaderboard"):
            runs.publisher.withdraw(ANN, "anns")
        runs.publish("anns", caller=ANN)
        runs.publisher.withdraw(ANN, "anns")


def test_a_run_that_is_being_played_is_not_published(backend: LeaderboardBackend) -> None:
    backend.run("r1", over=False)
    with pytest.raises(Conflict, match="run 'r1' is still being played: 0 of 6 episodes have ended"):
        backend.publish("r1")


def test_partial_runs_on_a_hidden_split_are_not_published(backend: LeaderboardBackend) -> None:
    backend.run("part", [1.0, 1.0], split="secret")
    with pytest.raises(Conflict) as caught:
        backend.publish("part")
    assert str(caught.value) == (
        "run 'part' has 2 of 3 episodes; the split 'secret' is hidden, "
        "and only runs of all its episodes can be published"
    )
    backend.publish(backend.run("whole", split="secret"))


def test_splits_for_training_are_neither_ranked_nor_listed(tmp_path: Path) -> None:
    backend = LeaderboardBackend(tmp_path, training=True)
    with closing(backend.database):
        backend.run("r1", split="extra")
        with pytest.raises(Conflict) as caught:
            backend.publish("r1")
        assert str(caught.value) == (
            "run 'r1' is on the split 'extra', which is for training alone; runs on such splits are not ranked"
        )
        assert sorted(backend.board.languages()) == ["secret", "tiny"]


@pytest.mark.parametrize(
    ("note", "message"),
    [
        ("x" * 501, "the note has 501 characters; at most 500 are allowed"),
        ("one\ntwo", "the note has U+000A (a control character); expected one line of visible text"),
        ("\u202eback", "the note has U+202E (RIGHT-TO-LEFT OVERRIDE); expected one line of visible text"),
        ("a\u200bb", "the note has U+200B (ZERO WIDTH SPACE); expected one line of visible text"),
        ("a\u2063b", "the note has U+2063 (INVISIBLE SEPARATOR); expected one line of visible text"),
        ("a\U000e0041b", "the note has U+E0041 (TAG LATIN CAPITAL LETTER A); expected one line of visible text"),
        (
            "a" + "\u0301" * 5,
            "the note has U+0301 (COMBINING ACUTE ACCENT) after 4 other marks; expected one line of visible text",
        ),
    ],
)
def test_invalid_notes_are_refused(backend: LeaderboardBackend, note: str, message: str) -> None:
    backend.run("r1")
    with pytest.raises(BadInput) as caught:
        backend.publish("r1", note)
    assert str(caught.value) == message


def test_valid_notes_are_published(backend: LeaderboardBackend) -> None:
    backend.run("r1")
    for note in ("", "x" * 500, "क्‍षेत्र, https://example.org/?a=b&c=<d>"):
        backend.publish("r1", note)
        assert backend.board.entry("r1").note == note
