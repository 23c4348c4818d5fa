"""Attempts of participants: all runs that were begun, on lists, in exports and in receipts."""

import json
from functools import partial

from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.standings import Standing
from arramon_server.runs.accounts.attempts import Attempts, attempt_number
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.receipts import stored_receipt
from arramon_server.runs.storage.records import CANCELLED
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.board.test_exports import read


def counted(lines: list[Standing]) -> dict[str, tuple[int, int]]:
    """Return the numbers of runs begun and published, by agent."""
    return {line.agent: (line.attempts.begun, line.attempts.published) for line in lines}


def test_every_run_that_was_begun_counts(backend: LeaderboardBackend) -> None:
    backend.participant("ann", "bob")
    run = partial(backend.run, account="ann", participant="ann")
    backend.publish(run("1", agent="mine"))
    run("2", agent="mine")  # not published
    run("3", agent="mine", over=False)  # being played
    backend.publisher.withdraw(HOST, backend.publish(run("4", agent="renamed")))
    backend.journal.set_state(run("5", over=False), CANCELLED)
    run("6", language="hi")
    run("7", split="secret")
    backend.publish(backend.run("8", agent="other", account="bob", participant="bob"))
    assert counted(backend.board.standings("tiny", "en")) == {"mine": (5, 1), "other": (1, 1)}
    run("9", agent="mine")
    assert counted(backend.board.standings("tiny", "en"))["mine"] == (6, 1)
    backend.publish("2")
    assert counted(backend.board.standings("tiny", "en")) == {"mine": (6, 2), "other": (1, 1)}
    assert backend.board.entry("2").attempts == Attempts(6, 2)


def test_all_languages_together_count_all_runs(backend: LeaderboardBackend) -> None:
    for run_id, language in (("1", "en"), ("2", "en"), ("3", "hi")):
        backend.run(run_id, language=language)
    backend.publish("1")
    backend.publish("3")
    assert counted(backend.board.combined_standings("tiny")) == {"walker": (3, 2)}


def test_without_accounts_names_tell_participants_apart(backend: LeaderboardBackend) -> None:
    backend.participant("ann")
    backend.publish(backend.run("1", agent="a", participant="lab"))
    backend.publish(backend.run("2", agent="b", participant="club"))
    backend.publish(backend.run("3", agent="c", participant="ann"))
    backend.publish(backend.run("4", agent="d", participant="ann", account="ann"))
    assert counted(backend.board.standings("tiny", "en")) == dict.fromkeys("abcd", (1, 1))


def test_exports_have_them(backend: LeaderboardBackend) -> None:
    backend.run("1")
    backend.publish(backend.run("2"))
    listing = backend.board.listing("tiny", "en")
    (cells,) = read(as_csv(listing))
    (line,) = json.loads(as_json(listing))["standings"]
    assert (cells["runs begun"], cells["runs published"]) == ("2", "1")
    assert (line["runs_begun"], line["runs_published"]) == (2, 1)


def test_a_receipt_states_them_at_its_time(backend: LeaderboardBackend) -> None:
    for run_id in ("1", "2", "3"):
        backend.run(run_id)
    backend.publish("2")
    backend.run("4")
    receipt = stored_receipt(backend.database, "2")
    assert receipt is not None
    assert json.loads(receipt.payload)["attempts"] == {"number": 2, "begun": 3}
    assert attempt_number(backend.database.read, backend.journal.run("2")) == (2, 4)
