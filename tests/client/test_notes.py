"""The command `notes`, on a real server and on one of an earlier release."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import cli
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import LEFT, Player, create
from tests.client.fake import Servicer, World, serving
from tests.serving import Server

NOTES = {"0": ["go on to the mug", "", "two\n\tlines [bold]"], "1": ['{"goal":[3,4],"दिशा":"बाएँ"}']}
"""Notes of each episode, by step."""

TEXT = """\
episode 0
  step 0: go on to the mug
  step 2: two
          \tlines [bold]
episode 1
  step 0: {"goal":[3,4],"दिशा":"बाएँ"}
"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data, count=2)
    server = Server(data, "127.0.0.1:0")
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def token(server: Server) -> str:
    return token_of(server.data, "ann")


@pytest.fixture(scope="module")
def run_id(server: Server, token: str) -> str:
    with Person(server.address, token) as person:
        run_id = create(person.stub, episode_ids=["1", "0"]).run_id
        with Player(person.stub, run_id, 2) as player:
            seen = {first.episode_id: first for first in (player.observation(), player.observation())}
            for episode_id, notes in NOTES.items():
                for step, note in enumerate(notes):
                    player.send([pb.Act(episode_id=episode_id, step=step, action=LEFT, note=note)])
                    assert player.observation().step == step + 1
        assert sorted(seen) == ["0", "1"]
        return run_id


def test_notes_are_printed_by_episode_and_step(
    server: Server, token: str, run_id: str, capsys: pytest.CaptureFixture[str]
) -> None:
    access = ("--server", server.address, "--token", token)
    assert cli.main(["notes", run_id, *access]) == 0
    assert capsys.readouterr() == (TEXT, "")
    assert cli.main(["notes", run_id, "1", *access]) == 0
    assert capsys.readouterr() == (TEXT[TEXT.index("episode 1") :], "")
    assert cli.main(["notes", run_id, "--json", *access]) == 0
    assert json.loads(capsys.readouterr().out) == [
        {"episode_id": episode_id, "step": step, "note": note}
        for episode_id, notes in NOTES.items()
        for step, note in enumerate(notes)
        if note
    ]


def test_a_run_without_notes_has_none(server: Server, token: str, capsys: pytest.CaptureFixture[str]) -> None:
    with Person(server.address, token) as person:
        bare = create(person.stub).run_id
    access = ("--server", server.address, "--token", token)
    assert cli.main(["notes", bare, *access]) == 0
    assert capsys.readouterr() == ("no notes\n", "")
    assert cli.main(["notes", bare, "--json", *access]) == 0
    assert json.loads(capsys.readouterr().out) == []


@pytest.mark.parametrize(
    ("episode", "has_token", "problem"),
    [("9", True, "has no episode '9'"), ("", False, "there is no run "), ("1", False, "there is no run ")],
)
def test_what_may_not_be_read_is_an_error(
    server: Server,
    token: str,
    run_id: str,
    capsys: pytest.CaptureFixture[str],
    episode: str,
    has_token: bool,
    problem: str,
) -> None:
    more = ("--token", token) if has_token else ()
    arguments = ["notes", run_id, *([episode] if episode else []), "--server", server.address, *more]
    assert cli.main(arguments) == 1
    said = capsys.readouterr()
    assert (said.out, said.err.startswith("error: "), problem in said.err) == ("", True, True), said.err


class EarlierServicer(Servicer):
    """Servicer of a release whose protocol had no notes."""

    def ListNotes(self, request: pb.ListNotesRequest, context: Any) -> pb.ListNotesResponse:  # noqa: N802
        context.abort(grpc.StatusCode.UNIMPLEMENTED, "Method not found!")
        raise AssertionError


def test_a_server_of_an_earlier_release_has_no_notes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with serving(EarlierServicer(World())) as address:
        assert cli.main(["notes", "5a" * 16, "--server", address]) == 1
        assert f"error: the server at {address} is of an earlier release, without notes\n" == capsys.readouterr().err
