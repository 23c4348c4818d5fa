"""Who may read a run's notes: its participant and hosts; everybody, once it is published on a split that is open."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2
from arramon_server.runs.accounts.callers import Role
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create
from tests.api.test_roles import code_of
from tests.serving import METADATA, Server

CALLERS = ("owner", "other", "host", "anonymous")

OK, ABSENT, NO, LATER = "OK", "NOT_FOUND", "PERMISSION_DENIED", "FAILED_PRECONDITION"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server as a host opens it to others, with an open, a hidden and a frozen split."""
    data = tmp_path_factory.mktemp("data")
    tiny.write(data, count=1)
    tiny.write(data, "secret", 1, hidden=True)
    tiny.write(data, "later", 1)
    limits = ("--runs-per-day", "0", "--runs-at-once", "0", "--closes", "later=2100-01-01", "--frozen")
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--anonymous", "--trust-proxy", *limits)
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def callers(server: Server) -> Iterator[dict[str, Person]]:
    tokens = {name: token_of(server.data, name) for name in ("owner", "other")}
    tokens |= {"host": token_of(server.data, "chair", Role.HOST), "anonymous": ""}
    with ExitStack() as stack:
        yield {name: stack.enter_context(Person(server.address, token)) for name, token in tokens.items()}


def run_with_a_note(owner: Person, split: str, *, over: bool = True) -> str:
    run_id = create(owner.stub, split=split).run_id
    with Player(owner.stub, run_id) as player:
        for step, action in enumerate(tiny.ACTIONS if over else tiny.ACTIONS[:1]):
            episode_id, note = player.observation().episode_id, "" if step else "mine"
            player.send([pb.Act(episode_id=episode_id, step=step, action=int(action), note=note)])  # type: ignore[arg-type]
        if over:
            assert list(player._events)[-1].HasField("run_ended")
        else:
            player.observation()
    return run_id


def answers(callers: dict[str, Person], run_id: str) -> tuple[str, ...]:
    """How the call ends for each of CALLERS; whoever gets an answer gets the note."""
    found = []
    for name in CALLERS:
        request, notes = pb.ListNotesRequest(run_id=run_id), list[str]()

        def call(name: str = name, request: pb.ListNotesRequest = request, notes: list[str] = notes) -> None:
            notes += [note.text for note in callers[name].stub.ListNotes(request, metadata=METADATA).notes]

        found.append(code_of(call))
        assert notes == (["mine"] if found[-1] == OK else [])
    return tuple(found)


@pytest.mark.parametrize(
    ("split", "state", "expected"),
    [
        ("tiny", "running", (OK, ABSENT, OK, ABSENT)),
        ("tiny", "over", (OK, ABSENT, OK, ABSENT)),
        ("tiny", "published", (OK, OK, OK, OK)),
        ("tiny", "withdrawn", (OK, ABSENT, OK, ABSENT)),
        ("secret", "running", (OK, ABSENT, OK, ABSENT)),
        ("secret", "over", (OK, ABSENT, OK, ABSENT)),
        ("secret", "published", (OK, NO, OK, NO)),
        ("later", "over", (OK, ABSENT, OK, ABSENT)),
        ("later", "published", (OK, LATER, OK, LATER)),
    ],
)
def test_notes_are_private_until_published_on_an_open_split(
    callers: dict[str, Person], split: str, state: str, expected: tuple[str, ...]
) -> None:
    owner = callers["owner"]
    run_id = run_with_a_note(owner, split, over=state != "running")
    if state in ("published", "withdrawn"):
        owner.board.Publish(leaderboard_pb2.PublishRequest(run_id=run_id), metadata=METADATA)
    if state == "withdrawn":
        owner.board.Withdraw(leaderboard_pb2.WithdrawRequest(run_id=run_id), metadata=METADATA)
    assert answers(callers, run_id) == expected


@pytest.mark.parametrize(("split", "expected"), [("tiny", (ABSENT, OK)), ("secret", (ABSENT, OK))])
def test_an_anonymous_run_is_open_to_callers_without_a_token_who_know_its_id(
    callers: dict[str, Person], split: str, expected: tuple[str, ...]
) -> None:
    run_id = run_with_a_note(callers["anonymous"], split)
    _, other, host, anonymous = answers(callers, run_id)
    assert ((other, anonymous), host) == (expected, OK)


def test_a_host_may_publish_an_anonymous_run_of_a_hidden_split_and_its_notes_stay_private(
    callers: dict[str, Person],
) -> None:
    """The leaderboard shows its id to everybody, so that knowing it no longer tells the owner."""
    run_id = run_with_a_note(callers["anonymous"], "secret")
    callers["host"].board.Publish(leaderboard_pb2.PublishRequest(run_id=run_id), metadata=METADATA)
    assert answers(callers, run_id) == (NO, NO, OK, NO)


def test_embedded_servers_answer_their_user(tmp_path: Path) -> None:
    """Anonymous callers on their own machine read the notes of their published runs, on hidden splits too."""
    tiny.write(tmp_path, "secret", 1, hidden=True)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8")
    with Person(server.address) as user:
        run_id = run_with_a_note(user, "secret")
        user.board.Publish(leaderboard_pb2.PublishRequest(run_id=run_id), metadata=METADATA)
        request = pb.ListNotesRequest(run_id=run_id)
        assert [note.text for note in user.stub.ListNotes(request, metadata=METADATA).notes] == ["mine"]
    assert server.stop() == 0
