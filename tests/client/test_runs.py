"""The commands `runs` and `cancel` on a real server, the version and the help."""

import json
import re
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, ClassVar

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import Episode, Observation, arguments, cli
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import create
from tests.serving import METADATA, Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)
    server = Server(data, "127.0.0.1:0", "--runs-at-once", "0,secret=1")
    yield server
    assert server.stop() == 0


class Ann:
    """A participant who uses the command line."""

    def __init__(self, server: Server, name: str, capsys: pytest.CaptureFixture[str]) -> None:
        self.token, self._server, self._capsys = token_of(server.data, name), server, capsys

    def command(self, word: str, *more: str) -> tuple[int, str, str]:
        self._capsys.readouterr()
        status = cli.main([word, *more, "--server", self._server.address, "--token", self.token])
        said = self._capsys.readouterr()
        return status, said.out, said.err

    def listed(self, *more: str) -> list[dict[str, Any]]:
        status, out, err = self.command("runs", "--json", *more)
        assert (status, err) == (0, "")
        found: list[dict[str, Any]] = json.loads(out)
        return found


def test_a_participant_finds_and_cancels_runs_that_use_up_the_quota(
    server: Server, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    ann = Ann(server, "ann", capsys)
    with Person(server.address, ann.token) as person:
        run = create(person.stub, split="secret").run_id
    play = ("--agent", "agents.stop", "--lang", "en", "--split", "secret", "--output", str(tmp_path), "--quiet")
    status, _, said = ann.command(*play)
    assert (status, run in said, "`arramon-client cancel RUN`" in said) == (1, True, True)
    assert [each["run_id"] for each in ann.listed("--state", "running", "--split", "secret")] == [run]
    assert ann.command("cancel", run) == (0, f"cancelled: {run}, test on secret, en\n", "")
    status, _, said = ann.command("cancel", run)
    assert (status, f"run {run!r} is already cancelled" in said) == (1, True)
    assert ann.command(*play)[0] == 0
    assert [each["state"] for each in ann.listed()] == ["complete", "cancelled"]


class Cancelling:
    """An agent whose run is cancelled elsewhere at its third batch."""

    sensors = ()
    cancel: ClassVar[Callable[[], object]]

    def __init__(self) -> None:
        self._batches = 0

    def begin(self, episode: Episode) -> None:
        pass

    def act(self, observations: Sequence[Observation]) -> list[int]:
        self._batches += 1
        if self._batches == 3:
            type(self).cancel()
        return [1 for _ in observations]


def test_a_player_whose_run_is_cancelled_is_told(
    server: Server, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    ann = Ann(server, "cancelled", capsys)
    with Person(server.address, ann.token) as person:
        Cancelling.cancel = lambda: [
            person.stub.CancelRun(pb.CancelRunRequest(run_id=each.run_id), metadata=METADATA)
            for each in person.stub.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs
        ]
        play = ("--agent", f"{__name__}:Cancelling", "--lang", "en", "--split", "tiny", "--output", str(tmp_path))
        status, out, said = ann.command(*play, "--quiet")
    (run,) = ann.listed("--state", "cancelled")
    assert f"run {run['run_id']} was cancelled: its unfinished episodes were given up" in said
    assert (status, "nDTW" in out) == (1, True)


def test_runs_are_listed_and_filtered(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    ann, bob = Ann(server, "lister", capsys), Ann(server, "bob", capsys)
    assert ann.command("runs") == (0, "no matching runs\n", "")
    with Person(server.address, ann.token) as person, Person(server.address, bob.token) as other:
        first = create(person.stub, episodes=2).run_id
        second = create(person.stub, language="hi", agent="two").run_id
        create(other.stub)
    for more, expected in (
        ((), [second, first]),
        (("--lang", "hi"), [second]),
        (("--agent", "test"), [first]),
        (("--split", "tiny"), [second, first]),
        (("--state", "complete"), []),
    ):
        assert [run["run_id"] for run in ann.listed(*more)] == expected
    status, out, err = ann.command("runs", "--limit", "1")
    assert (status, err) == (0, "only the latest 1 runs are listed: see --limit\n")
    lines = [re.split(r" {2,}", line) for line in out.splitlines()]
    assert lines[0] == ["run", "state", "agent", "split", "language", "episodes", "created", "ended"]
    assert lines[1][:6] == [second, "running", "two", "tiny", "hi", "0 of 4"]
    status, _, err = bob.command("cancel", first)
    assert (status, f"there is no run {first!r}" in err) == (1, True)


def test_runs_are_listed_across_pages(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    ann = Ann(server, "busy", capsys)
    with Person(server.address, ann.token) as person:
        made = [create(person.stub, episodes=1).run_id for _ in range(103)]
    assert [run["run_id"] for run in ann.listed("--limit", "200")] == made[::-1]
    assert [run["run_id"] for run in ann.listed("--limit", "103")] == made[::-1]


def test_version_option_prints_the_clients_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"arramon-client {version('arramon-client')}\n"


def test_the_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    shown = capsys.readouterr().out
    assert set(arguments.COMMANDS) == set(cli.COMMANDS)
    for word, does in arguments.COMMANDS.items():
        assert re.search(rf"^  {word} +{re.escape(does)}$", shown, re.MULTILINE)
        assert cli.main([word, "--help"]) == 0
        assert capsys.readouterr().out.startswith(f"usage: arramon-client {word} ")
