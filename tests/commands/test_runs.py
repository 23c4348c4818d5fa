"""`arramon-server runs`: the host lists and cancels runs, with and without a server."""

import json
import re
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_server import cli
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.api.people import Person
from tests.api.player import Player, create
from tests.serving import METADATA, Server


class Host:
    """A data folder, its journal and the host's own commands."""

    def __init__(self, data: Path, journal: str, capsys: pytest.CaptureFixture[str]) -> None:
        tiny.write(data)
        tiny.write(data, "secret", 3, hidden=True)
        self.data, self.journal, self._capsys = data, journal, capsys

    def token(self, name: str) -> str:
        with closing(Database(self.journal)) as database:
            return Accounts(database).create_token(name, Role.PARTICIPANT)

    def command(self, *arguments: str) -> tuple[int, str, str]:
        self._capsys.readouterr()
        status = cli.main(["runs", *arguments, "--data", str(self.data), "--journal", self.journal])
        said = self._capsys.readouterr()
        return status, said.out, said.err

    def listed(self, *arguments: str) -> list[dict[str, Any]]:
        status, out, err = self.command("--json", *arguments)
        assert (status, err) == (0, "")
        found: list[dict[str, Any]] = json.loads(out)
        return found

    def causes(self, run_id: str) -> dict[str, int]:
        with closing(Database(self.journal)) as database:
            return Journal(database).progress(run_id).causes

    @contextmanager
    def serving(self, *more: str) -> Iterator[Server]:
        server = Server(self.data, "127.0.0.1:0", "--journal", self.journal, "--steps", "8", *more)
        try:
            yield server
        finally:
            assert server.stop() == 0


@pytest.fixture
def host(tmp_path: Path, database_url: str, capsys: pytest.CaptureFixture[str]) -> Host:
    return Host(tmp_path / "data", database_url, capsys)


def test_runs_are_listed_and_filtered(host: Host) -> None:
    with host.serving() as server, Person(server.address, host.token("ann")) as ann, Person(server.address) as nobody:
        first = create(ann.stub, episodes=2).run_id
        second = create(ann.stub, split="secret").run_id
        third = create(nobody.stub, language="hi", agent="bobs", participant="bob").run_id
        nobody.stub.CancelRun(pb.CancelRunRequest(run_id=third), metadata=METADATA)
        for arguments, expected in (
            ((), [third, second, first]),
            (("list",), [third, second, first]),
            (("--participant", "ann"), [second, first]),
            (("--participant", "ann", "--split", "tiny"), [first]),
            (("--state", "cancelled"), [third]),
            (("--state", "running"), [second, first]),
            (("--agent", "test"), [second, first]),
            (("--split", "nowhere"), []),
        ):
            assert [run["run_id"] for run in host.listed(*arguments)] == expected
        status, out, err = host.command("--limit", "2")
        assert (status, err) == (0, "there are more than these 2 runs: see --limit\n")
        lines = [re.split(r" {2,}", line) for line in out.splitlines()]
        assert lines[0][:7] == ["run", "state", "participant", "agent", "split", "language", "episodes"]
        assert lines[1][:7] == [third, "cancelled", "bob", "bobs", "tiny", "hi", "4 of 4"]
        assert lines[2][:7] == [second, "running", "ann", "test", "secret", "en", "0 of 3"]
        assert lines[2][8] == "-"


def test_a_run_is_cancelled_without_a_server(host: Host) -> None:
    with host.serving() as server, Person(server.address) as nobody:
        run = create(nobody.stub).run_id
        with Player(nobody.stub, run) as player:
            first = player.observation()
            for step, action in enumerate(tiny.ACTIONS[:3]):
                player.act(first.episode_id, step, action)
                player.observation()
    said = f"cancelled: {run}, test by anonymous on tiny\n"
    assert host.command("cancel", run) == (0, said, "")
    assert host.causes(run) == {"FORFEITED": 6}
    assert host.command("cancel", run) == (1, "", f"arramon-server: run {run!r} is already cancelled\n")
    assert host.command("cancel", "none") == (1, "", "arramon-server: there is no run 'none'\n")
    with host.serving() as server, Person(server.address) as nobody:
        report = nobody.stub.GetReport(pb.GetReportRequest(run_id=run), metadata=METADATA)
        played = {episode.episode_id: episode.steps for episode in report.episodes}
        assert played.pop(first.episode_id) == 3
        assert set(played.values()) == {0}


@pytest.mark.parametrize("workers", ["1", "2"])
def test_running_server_notices_a_run_cancelled_by_the_host(host: Host, workers: str) -> None:
    with host.serving("--workers", workers) as server, Person(server.address, host.token("ann")) as ann:
        run, other = create(ann.stub).run_id, create(ann.stub).run_id
        # One that has all that it can have open and says nothing, one that could have more, and one of another run.
        with Player(ann.stub, run, 2, player="full") as full, Player(ann.stub, other, 1) as beside, ExitStack() as more:
            full.observation()
            free = more.enter_context(Player(ann.stub, run, 9, player="free"))
            free.observation()
            episode = beside.observation().episode_id
            assert host.command("cancel", run)[0] == 0
            for player in (full, free):
                while (event := player.next()).WhichOneof("event") != "run_ended":
                    assert event.WhichOneof("event") in ("episode_started", "observation")
                assert event.run_ended.run.state == pb.RUN_STATE_CANCELLED
                assert list(player.call) == []  # in good order
            assert host.causes(run) == {"FORFEITED": 6}
            beside.act(episode, 0, tiny.ACTIONS[0])
            assert beside.play(tiny.ACTIONS)[-1].run_ended.run.state == pb.RUN_STATE_COMPLETE
        assert [each["state"] for each in host.listed("--participant", "ann")] == ["complete", "cancelled"]


def test_run_on_changed_data_can_be_cancelled(host: Host) -> None:
    """It would count among a participant's unfinished runs for ever, as nobody can play it to its end."""
    with host.serving() as server, Person(server.address) as nobody:
        first, second = create(nobody.stub).run_id, create(nobody.stub).run_id
        with Player(nobody.stub, first) as player:
            player.act(player.observation().episode_id, 0, tiny.F)
            player.observation()
    tiny.write(host.data, count=5)
    assert host.command("cancel", first)[0] == 0
    assert host.causes(first) == {"SERVER_FAULT": 6}
    with host.serving("--runs-at-once", "1") as server, Person(server.address) as nobody:
        ended = nobody.stub.CancelRun(pb.CancelRunRequest(run_id=second), metadata=METADATA)
        assert (ended.state, dict(ended.causes)) == (pb.RUN_STATE_CANCELLED, {"SERVER_FAULT": 6})
        assert create(nobody.stub).state == pb.RUN_STATE_RUNNING


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("cancel",), "expected ids of runs and no filters: arramon-server runs cancel RUN ..."),
        (("cancel", "--state", "running"), "expected ids of runs and no filters: arramon-server runs cancel RUN ..."),
        (("list", "x"), "unexpected argument 'x': a list takes only filters, such as --participant NAME"),
    ],
)
def test_invalid_arguments_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], said: str
) -> None:
    assert cli.main(["runs", *arguments, "--data", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"arramon-server: {said}\n"
