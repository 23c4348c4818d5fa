"""Accounts over gRPC: authentication, access to runs, and secrecy of tokens."""

import asyncio
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import grpc
import pytest
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_reflection.v1alpha.proto_reflection_descriptor_database import ProtoReflectionDescriptorDatabase

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.api import authentication
from arramon_server.api.authentication import Authentication, anonymous_caller, current_caller, is_confidential
from arramon_server.api.error_guard import ErrorGuard
from arramon_server.api.interceptor import CallOrigin
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import ANONYMOUS, UNAUTHENTICATED, Caller, Role
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.api.people import Person, accounts, id_of, token_of
from tests.api.player import Player, create
from tests.api.test_roles import ABSENT, CASES
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

UNKNOWN = "0" * 32


@pytest.fixture(scope="module")
def people(closed: Server) -> Iterator[dict[str, Person]]:
    tokens = {name: token_of(closed.data, name) for name in ("ann", "bob")}
    tokens |= {"chair": token_of(closed.data, "chair", Role.HOST), "nobody": ""}
    with ExitStack() as stack:
        yield {name: stack.enter_context(Person(closed.address, token)) for name, token in tokens.items()}


def bearing(*values: str) -> tuple[tuple[str, str], ...]:
    return (*METADATA, *(("authorization", value) for value in values))


def listed(person: Person) -> list[str]:
    return [run.run_id for run in person.stub.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs]


def test_run_belongs_to_the_tokens_participant(people: dict[str, Person]) -> None:
    assert create(people["ann"].stub).participant == "ann"
    assert create(people["ann"].stub, participant="ann").participant == "ann"
    code, said = refused(lambda: create(people["ann"].stub, participant="bob"))
    assert (code, said) == (
        grpc.StatusCode.INVALID_ARGUMENT,
        "the participant is 'bob', expected the token's owner 'ann' or none",
    )


BY_RUN = [name for name, case in CASES.items() if case.expected[1] == ABSENT and name != "Leaderboard.CompareEpochs"]
"""Methods for a run that other participants do not see."""


@pytest.mark.parametrize("method", BY_RUN)
def test_runs_of_other_participants_look_like_unknown_runs(people: dict[str, Person], method: str) -> None:
    call = CASES[method].call
    over, running = create(people["ann"].stub, episodes=1).run_id, create(people["ann"].stub).run_id
    people["ann"].stub.CancelRun(pb.CancelRunRequest(run_id=over), metadata=METADATA)
    for run_id in (over, running, UNKNOWN):
        assert refused(lambda run_id=run_id: call(people["bob"], run_id)) == (
            grpc.StatusCode.NOT_FOUND,
            f"there is no run {run_id!r}",
        )
    kept = people["ann"].stub.GetRun(pb.GetRunRequest(run_id=running), metadata=METADATA)
    assert kept.state == pb.RUN_STATE_RUNNING


def test_participants_list_their_own_runs_and_hosts_list_all(people: dict[str, Person]) -> None:
    mine, other = create(people["ann"].stub).run_id, create(people["bob"].stub).run_id
    assert mine in listed(people["ann"])
    assert other not in listed(people["ann"])
    assert {mine, other} <= set(listed(people["chair"]))
    assert people["chair"].stub.GetRun(pb.GetRunRequest(run_id=mine), metadata=METADATA).participant == "ann"


@pytest.mark.parametrize("method", [name for name in CASES if name in BY_RUN or name.startswith("Evaluation.")])
def test_calls_without_a_token_are_refused_except_public_ones(people: dict[str, Person], method: str) -> None:
    nobody, call = people["nobody"], CASES[method].call
    if method == "Evaluation.GetServerInfo":
        assert not nobody.stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA).anonymous
        return
    of_published = ("Evaluation.GetBreakdown", "Evaluation.GetReceipt", "Evaluation.ListNotes")
    if method in of_published:  # runs that are not published are as if unknown
        mine = create(people["ann"].stub).run_id
        for run_id in (mine, UNKNOWN):
            refusal = refused(lambda run_id=run_id: call(nobody, run_id))
            assert refusal == (grpc.StatusCode.NOT_FOUND, f"there is no run {run_id!r}")
        published = create(people["ann"].stub, episodes=1).run_id
        with Player(people["ann"].stub, published) as player:
            player.play(tiny.ACTIONS)
        people["ann"].board.Publish(leaderboard_pb2.PublishRequest(run_id=published), metadata=METADATA)
        assert call(nobody, published) == call(people["bob"], published)
        return
    assert refused(lambda: call(nobody, UNKNOWN)) == (
        grpc.StatusCode.UNAUTHENTICATED,
        "authentication required: no token was sent; ask the server's host for one",
    )


def test_health_and_reflection_need_no_token(people: dict[str, Person]) -> None:
    channel = people["nobody"].channel
    for service in ("", "arramon.v1.Evaluation"):
        answer = health_pb2_grpc.HealthStub(channel).Check(health_pb2.HealthCheckRequest(service=service))
        assert answer.status == health_pb2.HealthCheckResponse.SERVING
    assert "arramon.v1.Evaluation" in ProtoReflectionDescriptorDatabase(channel).get_services()


WRONG_FORM = "bad `authorization` metadata: expected exactly one value, `Bearer TOKEN`"
NO_TOKEN = "authentication failed: malformed token; expected one that begins with arramon_"
NOT_KNOWN = "authentication failed: unknown token; ask the host for another one"


def test_malformed_unknown_revoked_and_expired_tokens_are_refused(closed: Server, people: dict[str, Person]) -> None:
    good, revoked, expired = (token_of(closed.data, "cleo") for _ in range(3))
    with accounts(closed.data) as kept:
        kept.revoke(id_of(revoked))
        expired = kept.create_token("cleo", Role.PARTICIPANT, days=1e-9)
    stub = people["nobody"].stub
    for sent, said in (
        (("Bearer",), WRONG_FORM),
        ((f"Basic {good}",), WRONG_FORM),
        ((f"Bearer {good}", f"Bearer {good}"), WRONG_FORM),
        (("Bearer sesame",), NO_TOKEN),
        (("Bearer arramon_",), NO_TOKEN),
        (("Bearer arramon_0123456789ab_" + "x" * 43,), NOT_KNOWN),
        ((f"Bearer {good[:-1]}",), NOT_KNOWN),
        ((f"Bearer {good}x",), NOT_KNOWN),
        ((f"Bearer {revoked[:-1]}",), NOT_KNOWN),
        (
            (f"Bearer {revoked}",),
            f"authentication failed: token {id_of(revoked)} was revoked; ask the host for another one",
        ),
    ):
        assert refused(lambda sent=sent: stub.ListRuns(pb.ListRunsRequest(), metadata=bearing(*sent))) == (
            grpc.StatusCode.UNAUTHENTICATED,
            said,
        )
    code, text = refused(lambda: stub.ListRuns(pb.ListRunsRequest(), metadata=bearing(f"Bearer {expired}")))
    assert code == grpc.StatusCode.UNAUTHENTICATED
    assert text.startswith(f"authentication failed: token {id_of(expired)} expired on ")
    assert stub.GetAccount(pb.GetAccountRequest(), metadata=bearing(f"bearer {good}")).participant == "cleo"


def test_open_methods_also_refuse_an_invalid_token(people: dict[str, Person]) -> None:
    stub = people["nobody"].stub
    call = lambda: stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=bearing("Bearer sesame"))  # noqa: E731
    assert refused(call) == (grpc.StatusCode.UNAUTHENTICATED, NO_TOKEN)


def test_revoking_a_token_ends_its_open_streams_and_later_calls(closed: Server) -> None:
    token = token_of(closed.data, "dora")
    with Person(closed.address, token) as dora:
        run = create(dora.stub, episodes=1)
        with Player(dora.stub, run.run_id) as player:
            first = player.observation()
            with accounts(closed.data) as kept:
                kept.revoke(id_of(token))

            def play_on() -> None:
                while True:  # until the server says no: the same answer again is answered again
                    player.act(first.episode_id, 0, 1)
                    player.next()
                    time.sleep(0.05)

            said = f"authentication failed: token {id_of(token)} was revoked; ask the host for another one"
            assert refused(play_on) == (grpc.StatusCode.UNAUTHENTICATED, said)
        assert refused(lambda: listed(dora)) == (grpc.StatusCode.UNAUTHENTICATED, said)


def test_tokens_are_never_written_to_files_or_logs(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    log = tmp_path / "log"
    token = token_of(tmp_path / "data", "ann")
    server = Server(tmp_path / "data", "127.0.0.1:0", "--log", "debug", log=log)
    with Person(server.address, token) as ann:
        run = create(ann.stub, episodes=1)
        with Player(ann.stub, run.run_id) as player:
            player.play(tiny.ACTIONS)
        ann.stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
        refused(lambda: ann.stub.GetRun(pb.GetRunRequest(run_id="x"), metadata=METADATA))
    with Person(server.address, token + "x") as mistyped:
        refused(lambda: listed(mistyped))
    during = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert any(path.name == "journal.db-wal" for path in during)
    contents = [path.read_bytes() for path in during]
    assert server.stop() == 0
    secret = token.split("_", 2)[2].encode()
    for content in [*contents, *(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())]:
        assert secret not in content
    assert log.stat().st_size > 0
    assert any(id_of(token).encode() in content for content in contents)  # what is kept of it is found by this search


def test_anonymous_runs_cannot_use_a_participants_name(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    token_of(tmp_path, "Lab One")
    server = Server(tmp_path)
    try:
        with Person(server.address) as anybody:
            for name in ("Lab One", "lab one", "ＬＡＢ one", "Lab\u200d One"):
                code, said = refused(lambda name=name: create(anybody.stub, participant=name))
                assert code == grpc.StatusCode.INVALID_ARGUMENT
                assert said.endswith("or can be confused with it; use the token, or another name")
            assert create(anybody.stub, participant="Lab Two").participant == "Lab Two"
            assert create(anybody.stub, participant="anonymous").participant == "anonymous"
            assert create(anybody.stub).participant == "anonymous"
            account = anybody.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA)
            assert (account.participant, account.role) == ("", pb.ROLE_ANONYMOUS)
    finally:
        assert server.stop() == 0


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[Accounts]:
    database = Database(f"sqlite:///{tmp_path / 'journal.db'}")
    yield Accounts(database)
    database.close()


@pytest.mark.parametrize(
    "name", ["ann", "Ann Müller-Öz", "प्रयोगशाला", "हिन्दी\u200d दल", "❤\ufe0f", "Nguyễn Thị", "x" * 100]
)
def test_valid_participant_names_are_accepted(kept: Accounts, name: str) -> None:
    assert kept.caller(kept.create_token(name, Role.PARTICIPANT)) == Caller(Role.PARTICIPANT, name)
    assert kept.caller(kept.create_token(name, Role.PARTICIPANT)) == Caller(Role.PARTICIPANT, name)


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        " ann",
        "ann ",
        "a  b",
        "a\tb",
        "a\nb",
        "a\u202eb",
        "x" * 101,
        "Anonymous",
        "\u3164",
        "a\u034f",
        "a\ufe00",
        "a" + 5 * "\u0336",
    ],
)
def test_invalid_participant_names_are_refused(kept: Accounts, name: str) -> None:
    with pytest.raises(BadInput):
        kept.create_token(name, Role.PARTICIPANT)
    assert kept.tokens() == []


def test_conflicting_names_and_invalid_token_options_are_refused(kept: Accounts) -> None:
    kept.create_token("Ann", Role.PARTICIPANT)
    for name, role, said in (
        ("ann", Role.PARTICIPANT, "the name 'ann' can be confused with that of the participant 'Ann'"),
        ("Ann\ufe0f", Role.PARTICIPANT, "the name 'Ann\ufe0f' can be confused with that of the participant 'Ann'"),
        ("Ann", Role.HOST, "'Ann' has the role participant; a host needs another name"),
    ):
        with pytest.raises(Conflict) as caught:
            kept.create_token(name, role)
        assert str(caught.value) == said
    for days in (0.0, -1.0, 36_501.0):
        with pytest.raises(BadInput, match="expected more than 0 and at most 36500"):
            kept.create_token("Ann", Role.PARTICIPANT, days=days)
    with pytest.raises(BadInput, match="the note has 201 characters"):
        kept.create_token("Ann", Role.PARTICIPANT, note="x" * 201)
    with pytest.raises(NotFound, match="there is no token 'x'"):
        kept.revoke("x")
    assert len(kept.tokens()) == 1


@pytest.mark.parametrize(
    ("listen", "trust_proxy", "anonymous", "expected"),
    [
        ("127.0.0.1:1", False, None, ANONYMOUS),
        ("localhost:1", False, None, ANONYMOUS),
        ("[::1]:1", False, None, ANONYMOUS),
        ("unix:/run/arramon.sock", False, None, ANONYMOUS),
        ("127.0.0.1:1", True, None, None),  # a proxy brings others to the loopback
        ("unix:/run/arramon.sock", True, None, None),
        ("0.0.0.0:1", False, None, None),
        ("10.0.0.1:1", False, None, None),
        ("127.0.0.1:1", False, False, None),
        ("127.0.0.1:1", True, True, UNAUTHENTICATED),
        ("10.0.0.1:1", False, True, UNAUTHENTICATED),
        ("127.0.0.1:1", False, True, ANONYMOUS),
    ],
)
def test_anonymous_access_depends_on_address_and_settings(
    listen: str, trust_proxy: bool, anonymous: bool | None, expected: Caller | None
) -> None:
    config = Config(data=Path(), listen=listen, trust_proxy=trust_proxy, anonymous=anonymous)
    assert anonymous_caller(config) == expected


def test_anonymous_callers_reach_a_run_only_by_its_id(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--trust-proxy", "--anonymous")
    try:
        with Person(server.address) as stranger:
            run = create(stranger.stub, episodes=1)
            assert listed(stranger) == []
            assert stranger.stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA) == run
    finally:
        assert server.stop() == 0


@pytest.mark.parametrize(
    ("peer", "transport", "private"),
    [
        ("ipv4:192.0.2.7:40000", b"ssl", True),
        ("ipv4:127.0.0.1:40000", b"insecure", True),
        ("ipv6:%5B::1%5D:40000", b"insecure", True),
        ("unix:", b"insecure", True),
        ("ipv4:192.0.2.7:40000", b"insecure", False),
        ("ipv6:%5B2001:db8::7%5D:40000", b"insecure", False),
    ],
)
def test_connections_are_private_over_tls_or_within_one_machine(peer: str, transport: bytes, private: bool) -> None:
    auth = {"transport_security_type": [transport]}
    context: Any = SimpleNamespace(peer=lambda: peer, auth_context=lambda: auth, invocation_metadata=tuple)
    assert is_confidential(CallOrigin.of(context)) is private


async def account_of(_request: pb.GetAccountRequest, _context: Any) -> pb.Account:
    return pb.Account(participant=current_caller().account or "")


def test_tokens_on_unencrypted_connections_are_refused(kept: Accounts, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test listens where others could reach it, so that this one's callers only pass for being elsewhere."""
    monkeypatch.setattr(authentication, "is_confidential", lambda _: False)
    metadata = bearing(f"Bearer {kept.create_token('ann', Role.PARTICIPANT)}")

    async def answer(**settings: bool) -> str:
        config = Config(data=Path(), **settings)  # type: ignore[arg-type]
        server = grpc.aio.server(interceptors=[ErrorGuard(), Authentication(kept, config)])
        handler: Any = grpc.unary_unary_rpc_method_handler(
            account_of, pb.GetAccountRequest.FromString, pb.Account.SerializeToString
        )
        server.add_generic_rpc_handlers([
            grpc.method_handlers_generic_handler("arramon.v1.Evaluation", {"GetAccount": handler})
        ])  # fmt: skip
        port = server.add_insecure_port("127.0.0.1:0")
        await server.start()
        try:
            async with grpc.aio.insecure_channel(f"127.0.0.1:{port}") as channel:
                call: Any = EvaluationStub(channel).GetAccount
                account = await call(pb.GetAccountRequest(), metadata=metadata)
                return str(account.participant)
        finally:
            await server.stop(None)

    with pytest.raises(grpc.RpcError) as caught:
        asyncio.run(answer())
    assert caught.value.code() == grpc.StatusCode.PERMISSION_DENIED
    assert "tokens are accepted over TLS only, and this connection is not encrypted" in (caught.value.details() or "")
    assert asyncio.run(answer(trust_proxy=True)) == "ann"


def test_requests_through_an_undeclared_proxy_need_a_token(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path)
    try:
        with Person(server.address) as anybody:
            assert len(anybody.stub.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs) == 0
            proxied = (*METADATA, ("x-forwarded-for", "192.0.2.7"))
            code, _ = refused(lambda: anybody.stub.ListRuns(pb.ListRunsRequest(), metadata=proxied))
            assert code == grpc.StatusCode.UNAUTHENTICATED
    finally:
        assert server.stop() == 0
