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
from tests.board.made import House
from tests.played import play
from tests.postgres import await_lock


@pytest.fixture
def house(tmp_path: Path, database_url: str) -> Iterator[House]:
    made = House(tmp_path, database_url)
    with closing(made.database):
        yield made


@pytest.fixture
def token(house: House) -> str:
    return Accounts(house.database).create_token("ann", Role.PARTICIPANT)


def standings(house: House) -> list[tuple[str, str]]:
    return sorted((line.participant, line.agent) for line in house.board.standings("tiny", "en"))


def test_accounts_are_listed_with_their_numbers(house: House, token: str) -> None:
    accounts = Accounts(house.database)
    accounts.revoke(accounts.create_token("ann", Role.PARTICIPANT).split("_")[1])
    accounts.create_token("ann", Role.PARTICIPANT, days=1e-9)
    accounts.create_token("chair", Role.HOST)
    Quotas(house.database, lambda *_: Quota()).set("anonymous", "tiny", {"runs_per_day": 1})  # no account
    house.publish(house.run("1", account="ann", participant="ann"))
    house.publisher.withdraw(HOST, house.publish(house.run("2", account="ann", participant="ann")))
    house.run("3", account="ann", participant="ann", over=False)
    house.run("4")
    found = Administration(house.database).all()
    assert [(each.participant, each.role, each.tokens, each.runs, each.running, each.published) for each in found] == [
        ("ann", Role.PARTICIPANT, 1, 3, 1, 1),
        ("chair", Role.HOST, 1, 0, 0, 0),
    ]
    assert {(each.banned_at, each.ban_reason, each.earlier_names) for each in found} == {(None, "", ())}


def test_a_renamed_account_keeps_tokens_limits_and_runs(house: House, token: str) -> None:
    quotas = Quotas(house.database, lambda *_: Quota())
    quotas.set("ann", "tiny", {"runs_per_day": 5})
    house.publish(house.run("1", account="ann", participant="ann", agent="mine"))
    house.run("2", participant="ann")  # an anonymous run of the same name, from before there were accounts
    assert standings(house) == [("ann", "mine")]
    Administration(house.database).rename("ann", "प्रयोगशाला")
    assert Accounts(house.database).caller(token) == Caller(Role.PARTICIPANT, "प्रयोगशाला")
    assert quotas.of("प्रयोगशाला", "tiny") == Quota(runs_per_day=5)
    assert (house.journal.run("1").account, house.journal.run("1").participant) == ("प्रयोगशाला",) * 2
    assert (house.journal.run("2").account, house.journal.run("2").participant) == (None, "ann")
    assert standings(house) == [("प्रयोगशाला", "mine")]  # also where the standings were cached
    assert attempt_number(house.database.read, house.journal.run("1")) == (1, 1)
    (account,) = Administration(house.database).all()
    assert account.earlier_names == ("ann",)


def test_earlier_names_stay_reserved_for_their_account(house: House, token: str) -> None:
    administration, accounts = Administration(house.database), Accounts(house.database)
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
    house: House, token: str, old: str, new: str, error: type[Exception], said: str
) -> None:
    Accounts(house.database).create_token("bob", Role.PARTICIPANT)
    before = Administration(house.database).all()
    with pytest.raises(error, match=said):
        Administration(house.database).rename(old, new)
    assert Administration(house.database).all() == before


def test_receipts_from_before_a_renaming_still_agree_with_the_journal(house: House, token: str) -> None:
    play(house.database, house.splits["tiny"], "r", account="ann")
    house.publisher._receipts.of(HOST, "r")
    with closing(Rescorer(house.database, house.splits)) as rescorer:
        assert rescorer.rescore("r").differences == ()
        before = stored_receipt(house.database, "r")
        Administration(house.database).rename("ann", "eva")
        assert stored_receipt(house.database, "r") == before
        assert rescorer.rescore("r").differences == ()
        with house.database.write() as connection:
            connection.execute(tables.earlier_names.delete())
        assert rescorer.rescore("r").differences == ("receipt: run: participant was ann, and is eva",)


def test_a_ban_refuses_tokens_and_withdraws_runs_until_it_ends(house: House, token: str) -> None:
    administration, accounts = Administration(house.database), Accounts(house.database)
    accounts.create_token("bob", Role.PARTICIPANT)
    mine = {"account": "ann", "participant": "ann"}
    for run_id, agent in (("1", "a"), ("2", "b"), ("3", "c")):
        house.publish(house.run(run_id, agent=agent, **mine))  # type: ignore[arg-type]
    house.publish(house.run("4", agent="d", account="bob", participant="bob"))
    house.publisher.withdraw(Caller(Role.PARTICIPANT, "ann"), "2")
    house.publisher.withdraw(HOST, "3")
    house.run("5", over=False, **mine)  # type: ignore[arg-type]
    assert administration.ban("ann", "two accounts") == (1, ["5"])
    assert standings(house) == [("bob", "d")]
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
    assert standings(house) == [("ann", "a"), ("bob", "d")]  # what was withdrawn before stays so
    with pytest.raises(Conflict, match="'ann' is not banned"):
        administration.unban("ann")


def test_what_the_host_withdraws_during_a_ban_stays_withdrawn(house: House, token: str) -> None:
    administration = Administration(house.database)
    for run_id in "12":
        house.publish(house.run(run_id, agent=f"agent {run_id}", account="ann", participant="ann"))
    assert administration.ban("ann") == (2, [])
    house.publisher.withdraw(HOST, "1")
    assert administration.unban("ann") == 1
    assert standings(house) == [("ann", "agent 2")]


def test_a_caller_that_a_process_still_knows_changes_nothing_after_a_ban_or_renaming(house: House, token: str) -> None:
    run_id, ann = house.run("1", account="ann", participant="ann"), Caller(Role.PARTICIPANT, "ann")
    administration = Administration(house.database)
    administration.ban("ann", "why")
    with house.database.write() as connection, pytest.raises(Forbidden, match="'ann' is banned: why"):
        check_may_act(connection, "ann")
    with pytest.raises(Forbidden, match="'ann' is banned: why"):
        house.publish(run_id, caller=ann)
    assert standings(house) == []
    house.publish(run_id)  # the host may
    assert standings(house) == [("ann", "walker")]
    administration.unban("ann")
    administration.rename("ann", "eva")
    with house.database.write() as connection, pytest.raises(TakenOver, match="'ann' was renamed just now"):
        check_may_act(connection, "ann")
    with house.database.write() as connection:
        check_may_act(connection, "eva")
        check_may_act(connection, None)


def test_a_ban_during_a_publication_withdraws_it(
    postgres_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    house = House(tmp_path, postgres_url)
    with closing(house.database), ThreadPoolExecutor(1) as pool:
        house.participant("ann")
        run_id = house.run("1", account="ann", participant="ann")
        bans = list[Future[tuple[int, list[str]]]]()

        def check_and_ban(connection: Connection, account: str | None) -> None:
            check_may_act(connection, account)
            bans.append(pool.submit(lambda: Administration(house.database).ban("ann")))
            await_lock(postgres_url, bans[0])

        monkeypatch.setattr(entries, "check_may_act", check_and_ban)
        house.publish(run_id, caller=Caller(Role.PARTICIPANT, "ann"))
        assert [ban.result() for ban in bans] == [(1, [])]
        assert standings(house) == []


@pytest.mark.parametrize("reason", ["x" * 501, "a\nb", "a\u202eb", "\u2063"])
def test_reasons_are_one_visible_line(house: House, token: str, reason: str) -> None:
    with pytest.raises(BadInput, match="expected one line of at most 500 characters"):
        Administration(house.database).ban("ann", reason)
    assert replace(Administration(house.database).all()[0]).banned_at is None
