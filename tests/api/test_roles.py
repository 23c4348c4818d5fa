"""Every call of the API by every role: what `docs/how-to/accounts.md` grants, and no more."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2
from arramon_server.runs.accounts.callers import Role
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import FORWARD, Player, create
from tests.serving import METADATA, Server

CALLERS = ("owner", "other", "host", "anonymous")
"""The run's participant, another participant, a host, and a caller without a token on a server that lets them play."""

OK, ABSENT, NO = "OK", "NOT_FOUND", "PERMISSION_DENIED"


@dataclass(frozen=True)
class Case:
    """One call: how it is made, on which kind of run, and how it ends for each of CALLERS."""

    call: Callable[[Person, str], object]
    run: str
    expected: tuple[str, str, str, str]


def plays(who: Person, run_id: str) -> object:
    """Opens a stream and plays one step, as a player of a name of its own that adopts what others have open."""
    with Player(who.stub, run_id, adopt=True) as player:
        seen = player.observation()
        player.act(seen.episode_id, seen.step, FORWARD)
        return player.observation()


CASES = {
    "Evaluation.GetServerInfo": Case(
        lambda who, _: who.stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA), "running", (OK,) * 4
    ),
    "Evaluation.CreateRun": Case(lambda who, _: create(who.stub), "running", (OK,) * 4),
    "Evaluation.GetAccount": Case(
        lambda who, _: who.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA), "running", (OK,) * 4
    ),
    "Evaluation.ListRuns": Case(  # the page that begins after this run
        lambda who, run: who.stub.ListRuns(pb.ListRunsRequest(page_token=run), metadata=METADATA),
        "running",
        (OK, ABSENT, OK, OK),  # the anonymous list is empty, see below
    ),
    "Evaluation.GetRun": Case(
        lambda who, run: who.stub.GetRun(pb.GetRunRequest(run_id=run), metadata=METADATA),
        "running",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Evaluation.CancelRun": Case(
        lambda who, run: who.stub.CancelRun(pb.CancelRunRequest(run_id=run), metadata=METADATA),
        "running",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Evaluation.Play": Case(plays, "running", (OK, ABSENT, NO, ABSENT)),
    "Evaluation.ListEpisodes": Case(
        lambda who, _: who.stub.ListEpisodes(pb.ListEpisodesRequest(split="tiny", language="en"), metadata=METADATA),
        "running",
        (OK,) * 4,
    ),
    "Evaluation.GetReport": Case(
        lambda who, run: who.stub.GetReport(pb.GetReportRequest(run_id=run), metadata=METADATA),
        "over",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Evaluation.GetReceipt": Case(
        lambda who, run: who.stub.GetReceipt(pb.GetReceiptRequest(run_id=run), metadata=METADATA),
        "over",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Evaluation.GetBreakdown": Case(
        lambda who, run: who.stub.GetBreakdown(pb.GetBreakdownRequest(run_id=run), metadata=METADATA),
        "over",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Evaluation.ListNotes": Case(
        lambda who, run: who.stub.ListNotes(pb.ListNotesRequest(run_id=run), metadata=METADATA),
        "over",
        (OK, ABSENT, OK, ABSENT),
    ),
    "Leaderboard.Publish": Case(
        lambda who, run: who.board.Publish(leaderboard_pb2.PublishRequest(run_id=run), metadata=METADATA),
        "over",
        (OK, ABSENT, OK, NO),
    ),
    "Leaderboard.Withdraw": Case(
        lambda who, run: who.board.Withdraw(leaderboard_pb2.WithdrawRequest(run_id=run), metadata=METADATA),
        "published",
        (OK, ABSENT, OK, NO),
    ),
    "Leaderboard.List": Case(
        lambda who, _: who.board.List(leaderboard_pb2.ListRequest(split="tiny"), metadata=METADATA),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.GetEntry": Case(
        lambda who, run: who.board.GetEntry(leaderboard_pb2.GetEntryRequest(run_id=run), metadata=METADATA),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.Compare": Case(
        lambda who, run: who.board.Compare(
            leaderboard_pb2.CompareRequest(run_id=run, language="en"), metadata=METADATA
        ),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.Export": Case(
        lambda who, _: who.board.Export(
            leaderboard_pb2.ExportRequest(split="tiny", format=leaderboard_pb2.ExportRequest.FORMAT_CSV),
            metadata=METADATA,
        ),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.GetActions": Case(
        lambda who, run: who.board.GetActions(leaderboard_pb2.GetActionsRequest(run_id=run), metadata=METADATA),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.ListEpochs": Case(
        lambda who, _: who.board.ListEpochs(leaderboard_pb2.ListEpochsRequest(), metadata=METADATA),
        "published",
        (OK,) * 4,
    ),
    "Leaderboard.CompareEpochs": Case(  # there are no such epochs, for anyone
        lambda who, _: who.board.CompareEpochs(
            leaderboard_pb2.CompareEpochsRequest(older="a", newer="b", language="en"), metadata=METADATA
        ),
        "published",
        (ABSENT,) * 4,
    ),
}


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server as a host opens it to others, who may also play without a token."""
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    limits = ("--runs-per-day", "0", "--runs-at-once", "0")
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--anonymous", "--trust-proxy", *limits)
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def callers(server: Server) -> Iterator[dict[str, Person]]:
    tokens = {name: token_of(server.data, name) for name in ("owner", "other")}
    tokens |= {"host": token_of(server.data, "chair", Role.HOST), "anonymous": ""}
    with ExitStack() as stack:
        yield {name: stack.enter_context(Person(server.address, token)) for name, token in tokens.items()}


def run_of(owner: Person, kind: str) -> str:
    """A new run of the owner, which is "running", "over" or "published"."""
    run_id = create(owner.stub, episodes=0 if kind == "published" else 1).run_id
    if kind != "running":
        with Player(owner.stub, run_id) as player:
            player.play(tiny.ACTIONS)
    if kind == "published":
        owner.board.Publish(leaderboard_pb2.PublishRequest(run_id=run_id), metadata=METADATA)
    return run_id


def code_of(call: Callable[[], object]) -> str:
    try:
        call()
    except grpc.RpcError as error:
        return str(error.code().name)
    return OK


def test_cases_cover_every_rpc_method() -> None:
    services = [
        service for file in (pb.DESCRIPTOR, leaderboard_pb2.DESCRIPTOR) for service in file.services_by_name.values()
    ]
    assert sorted(CASES) == sorted(
        f"{service.name}.{method.name}" for service in services for method in service.methods
    )


@pytest.mark.parametrize("method", CASES)
def test_every_role_may_call_what_is_granted_to_it(callers: dict[str, Person], method: str) -> None:
    case, found = CASES[method], []
    for name in CALLERS:
        run_id = run_of(callers["owner"], case.run)
        found.append(code_of(lambda name=name, run_id=run_id: case.call(callers[name], run_id)))  # type: ignore[misc]
    assert tuple(found) == case.expected


def test_a_host_neither_plays_a_participants_run_nor_takes_over_its_stream(callers: dict[str, Person]) -> None:
    run_id = run_of(callers["owner"], "running")
    with Player(callers["owner"].stub, run_id, player="mine") as player:
        seen = player.observation()
        for opening in ({}, {"player": "mine"}, {"adopt": True}, {"player": "mine", "history": True}):
            with Player(callers["host"].stub, run_id, **opening) as intruder, pytest.raises(grpc.RpcError) as caught:
                intruder.next()
            assert (caught.value.code(), caught.value.details()) == (
                grpc.StatusCode.PERMISSION_DENIED,
                f"run {run_id!r} belongs to owner, and only its participant can play it; a host can cancel it",
            )
        player.act(seen.episode_id, 0, FORWARD)  # its own stream goes on
        assert player.observation().step == 1
    run = callers["host"].stub.GetRun(pb.GetRunRequest(run_id=run_id), metadata=METADATA)
    assert (run.steps, run.participant) == (1, "owner")


def test_a_host_plays_its_own_runs_alone_also_beside_anonymous_ones(callers: dict[str, Person]) -> None:
    assert code_of(lambda: plays(callers["host"], create(callers["host"].stub).run_id)) == OK
    anonymous = create(callers["anonymous"].stub).run_id
    assert code_of(lambda: plays(callers["host"], anonymous)) == NO
    assert code_of(lambda: plays(callers["anonymous"], anonymous)) == OK
