"""`arramon-server account` and `arramon-server prune`, beside a running server."""

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2
from arramon_server import cli
from arramon_server.episodes.splits import split_folder
from arramon_server.runs.cancellation import Canceller
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import CANCELLED, COMPLETE, Run
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.serving import METADATA, Server

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(server: Server, capsys: pytest.CaptureFixture[str]) -> Command:
    def run(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        status = cli.main([*arguments, "--data", str(server.data)])
        said = capsys.readouterr()
        return status, said.out, said.err

    return run


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8")
    yield server
    assert server.stop() == 0


def finished(person: Person) -> str:
    run_id = create(person.stub).run_id
    with Player(person.stub, run_id, episodes=6) as player:
        player.play(tiny.ACTIONS)
    return run_id


def age(server: Server, run_id: str, days: float) -> None:
    at = datetime.now(UTC) - timedelta(days=days)
    with closing(Database(f"sqlite:///{server.data / 'journal.db'}")) as database, database.write() as connection:
        mine = tables.runs.c.run_id == run_id
        connection.execute(tables.runs.update().where(mine).values(created_at=at, ended_at=at))


def get(person: Person, run_id: str) -> pb.Run:
    run: pb.Run = person.stub.GetRun(pb.GetRunRequest(run_id=run_id), metadata=METADATA)
    return run


def test_a_ban_ends_open_streams_and_unban_restores_the_account(server: Server, command: Command) -> None:
    token = token_of(server.data, "ann")
    with Person(server.address, token) as ann, Person(server.address) as anybody:
        listed = finished(ann)
        ann.board.Publish(leaderboard_pb2.PublishRequest(run_id=listed), metadata=METADATA)
        run = create(ann.stub, episodes=1)
        with Player(ann.stub, run.run_id) as player:
            first = player.observation()
            assert command("account", "ban", "ann", "--reason", "played for another") == (
                0,
                f"ann is banned: its tokens are refused, 1 runs are withdrawn\ncancelled: {run.run_id}\n",
                "",
            )
            with pytest.raises((grpc.RpcError, StopIteration)):  # noqa: PT012 - it ends with its run, or with its token
                while True:
                    player.act(first.episode_id, 0, 1)
                    player.next()

        def refusal() -> tuple[grpc.StatusCode, str]:
            while True:  # a server knows a caller for up to two seconds
                try:
                    get(ann, run.run_id)
                except grpc.RpcError:
                    return refused(lambda: get(ann, run.run_id))

        said = "authentication failed: the account 'ann' is banned: played for another; ask the host"
        assert refusal() == (grpc.StatusCode.UNAUTHENTICATED, said)
        entry = leaderboard_pb2.GetEntryRequest(run_id=listed)
        assert refused(lambda: anybody.board.GetEntry(entry, metadata=METADATA))[0] == grpc.StatusCode.NOT_FOUND
        assert command("account", "unban", "ann") == (0, "ann is not banned any more: 1 runs are listed again\n", "")
        assert anybody.board.GetEntry(entry, metadata=METADATA).run.participant == "ann"
        (account,) = json.loads(command("account", "list", "--json")[1])
        assert (account["participant"], account["runs"], account["running"], account["published"]) == ("ann", 2, 0, 1)


def test_a_ban_cancels_all_runs_that_can_be_cancelled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = LeaderboardBackend(tmp_path)
    with closing(backend.database):
        backend.participant("ann")
        for run_id, split in (("1", "tiny"), ("2", "secret"), ("3", "tiny")):
            backend.run(run_id, split=split, account="ann", participant="ann", over=False)
        damaged = next(path for path in sorted(split_folder(tmp_path, "secret").rglob("*")) if path.is_file())
        whole = damaged.read_bytes()
        damaged.write_bytes(b"{")
        cancel = Canceller.cancel

        def end_first(canceller: Canceller, run_id: str) -> Run:
            if run_id == "1":
                backend.journal.set_state("1", COMPLETE)
            return cancel(canceller, run_id)

        monkeypatch.setattr(Canceller, "cancel", end_first)
        assert cli.main(["account", "ban", "ann", "--data", str(tmp_path)]) == 1
        said = capsys.readouterr()
        assert said.out == (
            "ann is banned: its tokens are refused, 0 runs are withdrawn\n"
            "not cancelled: run '1' is already complete\ncancelled: 3\n"
        )
        first, last = said.err.splitlines()
        assert first.startswith(f"not cancelled: 2: {damaged}")
        assert last == (
            "arramon-server: ann is banned, but 1 of its 3 unfinished runs could not be cancelled; "
            "fix the errors above, then repeat the command"
        )
        damaged.write_bytes(whole)
        assert cli.main(["account", "ban", "ann", "--data", str(tmp_path)]) == 0
        assert [backend.journal.run(run_id).state for run_id in "123"] == [COMPLETE, CANCELLED, CANCELLED]


def test_a_renamed_account_goes_on_with_its_token(server: Server, command: Command) -> None:
    with Person(server.address, token_of(server.data, "ann")) as ann:
        run = create(ann.stub, episodes=1)
        with Player(ann.stub, run.run_id) as player:
            first = player.observation()
            assert command("account", "rename", "ann", "Lab One") == (
                0,
                "ann is now Lab One; receipts that were signed before keep the old name\n",
                "",
            )
            player.act(first.episode_id, 0, 1)
            assert player.observation().step == 1  # its stream stays open
        while True:  # a server knows a caller for up to two seconds
            account = ann.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA)
            if account.participant == "Lab One":
                break
        assert get(ann, run.run_id).participant == "Lab One"
        assert create(ann.stub).participant == "Lab One"
        header, line = command("account", "list")[1].splitlines()
        assert line.split()[:3] == ["Lab", "One", "participant"]
        assert line.endswith(" ann")
        assert header.endswith("earlier names")


def test_runs_of_two_accounts_with_the_same_actions_are_shown(server: Server, command: Command) -> None:
    with Person(server.address, token_of(server.data, "ann")) as ann:
        mine = finished(ann)
    assert command("account", "duplicates")[1:] == ("", "no two runs of different accounts have that much in common\n")
    with Person(server.address, token_of(server.data, "bob")) as bob:
        yours = finished(bob)
    (pair,) = json.loads(command("account", "duplicates", "--json", "--split", "tiny")[1])
    assert [pair[name]["run_id"] for name in ("earlier", "later")] == [mine, yours]
    assert (pair["episodes"], pair["same"], pair["likeness"]) == (6, 6, 1.0)
    assert command("account", "duplicates")[1].splitlines()[1].split() == [
        "tiny", mine, "ann", "test", yours, "bob", "test", "6", "of", "6", "1.000",
    ]  # fmt: skip


def test_old_runs_are_pruned_beside_a_server_and_stay_counted(server: Server, command: Command) -> None:
    with Person(server.address, token_of(server.data, "ann")) as ann:
        old, kept = finished(ann), finished(ann)
        age(server, old, 40)
        line = f"{old}  complete  {datetime.now(UTC) - timedelta(days=40):%Y-%m-%d}  78 steps  test by ann on tiny\n"
        assert command("prune", "--older-than", "30", "--dry-run") == (
            0, f"{line}1 runs with 78 steps would be deleted\n", "",
        )  # fmt: skip
        assert get(ann, old).state == pb.RUN_STATE_COMPLETE
        with Player(ann.stub, create(ann.stub, episodes=1).run_id) as player:
            first = player.observation()
            assert command("prune", "--older-than", "30", "--compact") == (
                0, f"{line}1 runs with 78 steps deleted\n", "",
            )  # fmt: skip
            player.act(first.episode_id, 0, 1)
            assert player.observation().step == 1
        assert refused(lambda: get(ann, old)) == (grpc.StatusCode.NOT_FOUND, f"there is no run {old!r}")
        entry = ann.board.Publish(leaderboard_pb2.PublishRequest(run_id=kept), metadata=METADATA)
        assert (entry.runs_begun, entry.runs_published) == (3, 1)
        (quota,) = ann.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA).quotas
        assert quota.runs == 3
        age(server, kept, 40)
        assert command("prune", "--older-than", "30", "--with-receipts") == (0, "0 runs with 0 steps deleted\n", "")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("prune", "--older-than", "0.5"), "runs older than 0.5 days were requested, expected 1 to 36500"),
        (("account", "rename", "eve", "x"), "there is no account 'eve'; `arramon-server account list` shows them"),
        (("account", "ban", "eve"), "there is no account 'eve'; `arramon-server account list` shows them"),
        (("account", "unban", "eve"), "there is no account 'eve'; `arramon-server account list` shows them"),
        (("account", "duplicates", "--least", "2"), "the likeness is 2, expected 0 to 1"),
    ],
)
def test_invalid_arguments_are_refused(server: Server, command: Command, arguments: tuple[str, ...], said: str) -> None:
    assert command(*arguments) == (1, "", f"arramon-server: {said}\n")
