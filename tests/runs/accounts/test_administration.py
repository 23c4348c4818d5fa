"""Accounts are renamed and banned with their tokens, limits and runs, and a ban can be ended."""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy.engine import Connection

from arramon_server.board import entries
from arramon_server.errors import BadInput, Conflict, Forbidden, NotFound, TakenOver, Unauthenticated
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.administration import Administration, check_may_act
from arramon_server.runs.accounts.attempts import attempt_number
from arramon_server.runs.accounts.callers import HOST, Caller, Role
from arramon_server.runs.accounts.quotas import Quota, Quotas
from arramon_server.runs.results.receipts import stored_receipt
from arramon_server.runs.results.rescoring import Rescorer
from arramon_server.runs.storage import tables
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.played import play
from tests.postgres import await_lock


@pytest.fixture
def backend(tmp_path: Path, database_url: str) -> Iterator[LeaderboardBackend]:
    made = LeaderboardBackend(tmp_path, database_url)
    with closing(made.database):
        yield made


@pytest.fixture
def token(backend: LeaderboardBackend) -> str:
    return Accounts(backend.database).create_token("ann", Role.PARTICIPANT)


def standings(backend: LeaderboardBackend) -> list[tuple[str, str]]:
    return sorted((line.participant, line.agent) for line in backend.board.standings("tiny", "en"))


def test_accounts_are_listed_with_their_numbers(backend: LeaderboardBackend, token: str) -> None:
    accounts = Accounts(backend.database)
    accounts.revoke(accounts.create_token("ann", Role.PARTICIPANT).split("_")[1])
    accounts.create_token("ann", Role.PARTICIPANT, days=1e-9)
    accounts.create_token("chair", Role.HOST)
    Quotas(backend.database, lambda *_: Quota()).set("anonymous", "tiny", {"runs_per_day": 1})  # no account
    backend.publish(backend.run("1", account="ann", participant="ann"))
    backend.publisher.withdraw(HOST, backend.publish(backend.run("2", account="ann", participant="ann")))
    backend.run("3", account="ann", participant="ann", over=False)
    backend.run("4")
    found = Administration(backend.database).all()
    assert [(each.participant, each.role, each.tokens, each.runs, each.running, each.published) for each in found] == [
        ("ann", Role.PARTICIPANT, 1, 3, 1, 1),
        ("chair", Role.HOST, 1, 0, 0, 0),
    ]
    assert {(each.banned_at, each.ban_reason, each.earlier_names) for each in found} == {(None, "", ())}


def test_a_renamed_account_keeps_tokens_limits_and_runs(backend: LeaderboardBackend, token: str) -> None:
    quotas = Quotas(backend.database, lambda *_: Quota())
    quotas.set("ann", "tiny", {"runs_per_day": 5})
    backend.publish(backend.run("1", account="ann", participant="ann", agent="mine"))
    backend.run("2", participant="ann")  # an anonymous run of the same name, from before there were accounts
    assert standings(backend) == [("ann", "mine")]
    Administration(backend.database).rename("ann", "प्रयोगशाला")
    assert Accounts(backend.database).caller(token) == Caller(Role.PARTICIPANT, "प्रयोगशाला")
    assert quotas.of("प्रयोगशाला", "tiny") == Quota(runs_per_day=5)
    assert (backend.journal.run("1").account, backend.journal.run("1").participant) == ("प्रयोगशाला",) * 2
    assert (backend.journal.run("2").account, backend.journal.run("2").participant) == (None, "ann")
    assert standings(backend) == [("प्रयोगशाला", "mine")]  # also where the standings were cached
    assert attempt_number(backend.database.read, backend.journal.run("1")) == (1, 1)
    (account,) = Administration(backend.database).all()
    assert account.earlier_names == ("ann",)


def test_earlier_names_stay_reserved_for_their_account(backend: LeaderboardBackend, token: str) -> None:
    administration, accounts = Administration(backend.database), Accounts(backend.database)
    accounts.create_token("bob", Role.PARTICIPANT)
    administration.rename("ann", "eva")
    for create in (
        lambda: accounts.create_token("Ann", Role.PARTICIPANT),
        lambda: administration.rename("bob", "ＡNN"),
    ):
        with pytest.raises(Conflict, match="can be confused with 'ann', an earlier name of 'eva'"):
            create()
    assert accounts.is_taken("ann")
    administration.rename("eva", "Eva")  # its own names are free
    administration.rename("Eva", "ann")
    found = {each.participant: each.earlier_names for each in administration.all()}
    assert found == {"ann": ("Eva", "eva"), "bob": ()}


@pytest.mark.parametrize(
    ("old", "new", "error", "said"),
    [
        ("eve", "adam", NotFound, "there is no account 'eve'"),
        ("anonymous", "adam", BadInput, "'anonymous' stands for all callers without a token"),
        ("ann", "ann", Conflict, "the account has the name 'ann' already"),
        ("ann", "BOB", Conflict, "can be confused with that of the participant 'bob'"),
        ("ann", "a\u200bb", BadInput, "has invisible characters"),
        ("ann", "Anonymous", BadInput, "is reserved for callers without a token"),
    ],
)
def test_invalid_renames_change_nothing(
    backend: LeaderboardBackend, token: str, old: str, new: str, error: type[Exception], said: str
) -> None:
    Accounts(backend.database).create_token("bob", Role.PARTICIPANT)
    before = Administration(backend.database).all()
    with pytest.raises(error, match=said):
        Administration(backend.database).rename(old, new)
    assert Administration(backend.database).all() == before


def test_receipts_from_before_a_renaming_still_agree_with_the_journal(backend: LeaderboardBackend, token: str) -> None:
    play(backend.database, backend.splits["tiny"], "r", account="ann")
    backend.publisher._receipts.of(HOST, "r")
    with closing(Rescorer(backend.database, backend.splits)) as rescorer:
        assert rescorer.rescore("r").differences == ()
        before = stored_receipt(backend.database, "r")
        Administration(backend.database).rename("ann", "eva")
        assert stored_receipt(backend.database, "r") == before
        assert rescorer.rescore("r").differences == ()
        with backend.database.write() as connection:
            connection.execute(tables.earlier_names.delete())
        assert rescorer.rescore("r").differences == ("receipt: run: participant was ann, and is eva",)


def test_a_ban_refuses_tokens_and_withdraws_runs_until_it_ends(backend: LeaderboardBackend, token: str) -> None:
    administration, accounts = Administration(backend.database), Accounts(backend.database)
    accounts.create_token("bob", Role.PARTICIPANT)
    mine = {"account": "ann", "participant": "ann"}
    for run_id, agent in (("1", "a"), ("2", "b"), ("3", "c")):
        backend.publish(backend.run(run_id, agent=agent, **mine))  # type: ignore[arg-type]
    backend.publish(backend.run("4", agent="d", account="bob", participant="bob"))
    backend.publisher.withdraw(Caller(Role.PARTICIPANT, "ann"), "2")
    backend.publisher.withdraw(HOST, "3")
    backend.run("5", over=False, **mine)  # type: ignore[arg-type]
    assert administration.ban("ann", "two accounts") == (1, ["5"])
    assert standings(backend) == [("bob", "d")]
    with pytest.raises(Unauthenticated, match="the account 'ann' is banned: two accounts; ask the host"):
        accounts.caller(token)
    with pytest.raises(Conflict, match="'ann' is banned"):
        accounts.create_token("ann", Role.PARTICIPANT)
    with pytest.raises(Unauthenticated, match="unknown token"):  # nothing is told without the whole token
        accounts.caller(token[:-1])
    (banned, _) = administration.all()
    assert (banned.ban_reason, banned.published) == ("two accounts", 0)
    assert banned.banned_at is not None
    assert administration.ban("ann") == (0, ["5"])  # once more changes nothing
    assert administration.all()[0] == banned
    assert administration.unban("ann") == 1
    assert accounts.caller(token) == Caller(Role.PARTICIPANT, "ann")
    assert standings(backend) == [("ann", "a"), ("bob", "d")]  # what was withdrawn before stays so
    with pytest.raises(Conflict, match="'ann' is not banned"):
        administration.unban("ann")


def test_what_the_host_withdraws_during_a_ban_stays_withdrawn(backend: LeaderboardBackend, token: str) -> None:
    administration = Administration(backend.database)
    for run_id in "12":
        backend.publish(backend.run(run_id, agent=f"agent {run_id}", account="ann", participant="ann"))
    assert administration.ban("ann") == (2, [])
    backend.publisher.withdraw(HOST, "1")
    assert administration.unban("ann") == 1
    assert standings(backend) == [("ann", "agent 2")]


def test_a_caller_that_a_process_still_knows_changes_nothing_after_a_ban_or_renaming(
    backend: LeaderboardBackend, token: str
) -> None:
    run_id, ann = backend.run("1", account="ann", participant="ann"), Caller(Role.PARTICIPANT, "ann")
    administration = Administration(backend.database)
    administration.ban("ann", "why")
    with backend.database.write() as connection, pytest.raises(Forbidden, match="'ann' is banned: why"):
        check_may_act(connection, "ann")
    with pytest.raises(Forbidden, match="'ann' is banned: why"):
        backend.publish(run_id, caller=ann)
    assert standings(backend) == []
    backend.publish(run_id)  # the host may
    assert standings(backend) == [("ann", "walker")]
    administration.unban("ann")
    administration.rename("ann", "eva")
    with backend.database.write() as connection, pytest.raises(TakenOver, match="'ann' was renamed just now"):
        check_may_act(connection, "ann")
    with backend.database.write() as connection:
        check_may_act(connection, "eva")
        check_may_act(connection, None)


def test_a_ban_during_a_publication_withdraws_it(
    postgres_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = LeaderboardBackend(tmp_path, postgres_url)
    with closing(backend.database), ThreadPoolExecutor(1) as pool:
        backend.participant("ann")
        run_id = backend.run("1", account="ann", participant="ann")
        bans = list[Future[tuple[int, list[str]]]]()

        def check_and_ban(connection: Connection, account: str | None) -> None:
            check_may_act(connection, account)
            bans.append(pool.submit(lambda: Administration(backend.database).ban("ann")))
            await_lock(postgres_url, bans[0])

        monkeypatch.setattr(entries, "check_may_act", check_and_ban)
        backend.publish(run_id, caller=Caller(Role.PARTICIPANT, "ann"))
        assert [ban.result() for ban in bans] == [(1, [])]
        assert standings(backend) == []


@pytest.mark.parametrize("reason", ["x" * 501, "a\nb", "a\u202eb", "\u2063"])
def test_reasons_are_one_visible_line(backend: LeaderboardBackend, token: str, reason: str) -> None:
    with pytest.raises(BadInput, match="expected one line of at most 500 characters"):
        Administration(backend.database).ban("ann", reason)
    assert replace(Administration(backend.database).all()[0]).banned_at is None
