"""Clients that play against a server that lies, in every field of every message that it sends."""

import contextlib
import hashlib
import io
import json
import math
import re
import sys
import threading
import tracemalloc
from collections.abc import Iterator, Sequence
from itertools import count, cycle, islice
from pathlib import Path
from typing import Any

import grpc
import gymnasium
import pytest

import arramon_client.environments  # noqa: F401 - registers them
from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.cli import main
from arramon_client.commands import leaderboard, notes
from arramon_client.errors import ArramonClientError
from arramon_client.multi_stream import own_addresses
from arramon_client.runs import listing
from arramon_client.transport.access import Access
from arramon_client.transport.connection import CONNECTION_LOST, Server
from tests.client.test_verify import HOST_KEY, payload, signed
from tests.hostile.liar import (
    ANSWERS,
    BOMBS,
    EPISODE,
    RUN,
    SIZE,
    SPLIT,
    TEXTS,
    TRUE,
    Liar,
    Lie,
    bombs,
    full,
    lies,
    lying,
    messages_in,
)

AGENT = """
class Agent:
    name = "liars_agent"
    sensors = ("rgb",)
    def begin(self, episode): print("began", episode.episode_id)
    def act(self, observations): return [0 for _ in observations]
"""

UNSAFE = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u200b\u200e\u200f\u202a-\u202e\u2060-\u2069\U000e0000-\U000e007f]"
)

PLAY = ("--agent", "liars_agent", "--lang", "en", "--quiet")

COMMANDS: dict[tuple[str, ...], tuple[str, ...]] = {
    (*PLAY, "--record", "rec"): ("GetServerInfo", "CreateRun", "Play", "GetReport", "GetReceipt"),
    (*PLAY, "--dry-run"): ("GetServerInfo", "CreateRun", "Play", "GetReport", "GetReceipt"),
    ("--agent", "liars_agent", "--resume", RUN): ("GetServerInfo", "GetRun", "Play", "GetReport", "GetReceipt"),
    ("account",): ("GetServerInfo", "GetAccount"),
    ("runs",): ("GetServerInfo", "ListRuns"),
    ("runs", "--json"): ("GetServerInfo", "ListRuns"),
    ("cancel", RUN): ("GetServerInfo", "CancelRun"),
    ("leaderboard", "--split", SPLIT): ("GetServerInfo", "List"),
    ("leaderboard", "--split", SPLIT, "--csv"): ("GetServerInfo", "Export"),
    ("leaderboard", "--split", SPLIT, "--json"): ("GetServerInfo", "Export"),
    ("leaderboard", "--against", RUN): ("GetServerInfo", "Compare"),
    ("leaderboard", "--reproductions", RUN): ("GetServerInfo", "GetEntry"),
    ("publish", RUN): ("GetServerInfo", "Publish"),
    ("withdraw", RUN): ("GetServerInfo", "Withdraw"),
    ("report", RUN): ("GetServerInfo", "GetBreakdown"),
    ("report", RUN, "--metric", "both"): ("GetServerInfo", "GetBreakdown"),
    ("report", RUN, "--json"): ("GetServerInfo", "GetBreakdown"),
    ("notes", RUN): ("GetServerInfo", "ListNotes"),
    ("notes", RUN, EPISODE, "--json"): ("GetServerInfo", "ListNotes"),
    ("epochs",): ("GetServerInfo", "ListEpochs"),
    ("epochs", "--json"): ("GetServerInfo", "ListEpochs"),
    ("epochs", "--compare", "a_e1", "a_e2", "--lang", "en"): ("GetServerInfo", "CompareEpochs"),
}
"""A command -> the methods that it calls."""


class Victim:
    """A participant who uses the client in a folder of their own, and what became of that.

    Args:
        folder: in which the client runs, some levels below one that nothing else writes to.
        outside: that folder.
        liar, address: the server.
    """

    def __init__(self, folder: Path, outside: Path, liar: Liar, address: str) -> None:
        self.folder, self._outside, self.liar, self.address = folder, outside, liar, address
        self._thread_errors: list[str] = []
        threading.excepthook = lambda given: self._thread_errors.append(repr(given.exc_value))

    def run(self, *arguments: str) -> tuple[int, str]:
        """Run a command; return its status and what it printed, after looking for harm."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main([*arguments, "--server", self.address])
        said = out.getvalue() + err.getvalue()
        assert not self._thread_errors, self._thread_errors
        assert status in (0, 1, 2, 3, 4), (status, said)
        assert "Traceback" not in said, said
        found = UNSAFE.search(said)
        assert found is None, (found, said[:2000])
        assert len(said) < 100_000 or "--csv" in arguments or "--json" in arguments
        self.look_around()
        return status, said

    def look_around(self) -> None:
        """Look for files outside the folders for results, and for what is not text in them."""
        for path in self._outside.rglob("*"):
            if path.is_dir() or path.suffix in (".jpg", ".png") or "__pycache__" in path.parts:
                continue
            where = path.relative_to(self.folder) if path.is_relative_to(self.folder) else path
            assert where.parts[0] in ("arramon-results", "rec", "liars_agent.py"), f"{path} was written"
            found = UNSAFE.search(path.read_text())
            assert found is None, (path, found)


@pytest.fixture
def victim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Victim]:
    folder = tmp_path / "a" / "b" / "c"
    folder.mkdir(parents=True)
    (folder / "liars_agent.py").write_text(AGENT)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    liar = Liar()
    with lying(liar) as address:
        yield Victim(folder, tmp_path, liar, address)
    sys.modules.pop("liars_agent", None)
    assert not Path("/tmp/arramon-escaped.json").exists()


def methods_with(message: str) -> list[str]:
    return [name for name, answer in ANSWERS.items() if message in messages_in(answer.DESCRIPTOR)]


MESSAGES = {
    name: each
    for file in {answer.DESCRIPTOR.file for answer in ANSWERS.values()} | {types_pb2.DESCRIPTOR}
    for name, each in file.message_types_by_name.items()
    if methods_with(name) and set(methods_with(name)) & {called for calls in COMMANDS.values() for called in calls}
}


@pytest.mark.parametrize("arguments", COMMANDS, ids=" ".join)
def test_without_lies_the_commands_succeed(victim: Victim, arguments: Sequence[str]) -> None:
    """So that the lies are what the other tests are about."""
    status, said = victim.run(*arguments)
    assert status == 0, said


@pytest.mark.parametrize("message", sorted(MESSAGES))
def test_no_false_field_harms_the_client(victim: Victim, message: str) -> None:
    """Every false value of every field, each with the next of the commands that receive the message."""
    receive = [command for command, calls in COMMANDS.items() if set(calls) & set(methods_with(message))]
    assert receive
    commands = cycle(receive)
    for lie in lies(MESSAGES[message]):
        victim.liar.lie, victim.liar.told = lie, 0
        for command in islice(commands, len(receive)):
            try:
                victim.run(*command)
            except BaseException as error:
                error.add_note(f"{' '.join(command)}: {lie}")
                raise
            if victim.liar.told:
                break
        assert victim.liar.told, f"{lie} was not told"


@pytest.mark.parametrize("message", ["ServerInfo", "Host", "Entry", "Correction", "SupersededReceipt"])
def test_verify_prints_nothing_harmful_of_what_superseded_a_receipt(victim: Victim, message: str) -> None:
    receipt = signed(payload())
    path = victim.folder / "arramon-results" / "r7.receipt.json"
    path.parent.mkdir()
    path.write_text(json.dumps(receipt))
    digest = hashlib.sha256(receipt["payload"].encode()).digest()
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(TRUE, "ServerInfo.public_key", bytes.fromhex(HOST_KEY))
        patched.setitem(TRUE, "SupersededReceipt.digest", digest)
        status, said = victim.run("verify", str(path))
        assert (status, "SUPERSEDED at superseded_at" in said) == (4, True), said
        assert "(corrected at made_at: " in said, said
        for lie in lies(MESSAGES[message]):
            victim.liar.lie, victim.liar.told = lie, 0
            victim.run("verify", str(path))
            assert victim.liar.told, lie


@pytest.mark.parametrize("run_id", [text for text in TEXTS if text])
@pytest.mark.parametrize("message", ["Run", "Report", "Opened"])
def test_a_false_run_id_is_named_and_nothing_is_written(victim: Victim, run_id: str, message: str) -> None:
    victim.liar.lie = Lie("Run", "run_id", run_id)
    status, said = victim.run(*PLAY)
    assert status == 1
    assert "expected 32 hexadecimal digits" in said
    assert len(said.splitlines()) == 1
    assert [*victim.folder.joinpath("arramon-results").iterdir()] == []


CODES = [code for code in grpc.StatusCode if code is not grpc.StatusCode.OK]


@pytest.mark.parametrize("text", [text[:4000] for text in TEXTS if text])
def test_no_refusal_harms_the_client(victim: Victim, text: str) -> None:
    """Of no call of any command, with any status. A connection that is lost is tried again, so not that one."""
    short = [command for command in COMMANDS if command[0] != "--agent"]
    for number, code in enumerate(code for code in CODES if code not in CONNECTION_LOST):
        victim.liar.refusal = (code, text)
        for command in (PLAY, ("--agent", "liars_agent", "--resume", RUN), short[number % len(short)]):
            status, said = victim.run(*command)
            assert status == 1
            assert len(said.splitlines()) == 1, said


@pytest.mark.parametrize("name", BOMBS)
def test_no_image_is_decoded_that_was_not_requested(victim: Victim, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    victim.liar.image = bombs()[name]
    tracemalloc.start()
    try:
        status, said = victim.run(*PLAY, "--record", "rec")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert status == 1, said
    assert sum(line.startswith("error: ") for line in said.splitlines()) == 1, said
    assert peak < 64 * 1024 * 1024


EVENTS: dict[str, tuple[list[pb.Event], str]] = {
    "another run": ([pb.Event(run_ended=pb.RunEnded(run=pb.Run(run_id="6b" * 16)))], "expected 5a5a"),
    "shared memory that was not requested": (
        [pb.Event(opened=pb.Opened(run=pb.Run(run_id=RUN), encoding=types_pb2.ENCODING_SHARED))],
        "shared memory, which was not requested",
    ),
    "too many episodes": (
        [pb.Event(episode_started=pb.EpisodeStarted(episode_id=f"e{i}", language="en")) for i in range(2000)],
        "more than the 8 episodes that were requested",
    ),
    "problems without end": (
        [pb.Event(problem=pb.Problem(code=pb.Problem.CODE_NOT_YOUR_EPISODE, episode_id=EPISODE))] * 2000,
        "reported more than 1000 problems",
    ),
    "an action that is none": (
        [
            pb.Event(episode_started=pb.EpisodeStarted(episode_id=EPISODE, language="en")),
            pb.Event(observation=pb.Observation(episode_id=EPISODE, turn=1, taken=9)),  # type: ignore[arg-type]
        ],
        "has the action 9, expected 0 to 3",
    ),
    "a note that is too long": (
        [
            pb.Event(episode_started=pb.EpisodeStarted(episode_id=EPISODE, language="en")),
            pb.Event(observation=pb.Observation(episode_id=EPISODE, turn=1, taken=1, taken_note="m" * 2049)),  # type: ignore[arg-type]
        ],
        "a note that the server sent has 2049 characters, expected at most 2048",
    ),
    "a pose that is no number": (
        [
            pb.Event(episode_started=pb.EpisodeStarted(episode_id=EPISODE, language="en")),
            pb.Event(observation=pb.Observation(episode_id=EPISODE, turn=1, pose=types_pb2.Pose(x=math.nan))),
        ],
        "expected a finite number",
    ),
}


@pytest.mark.parametrize("name", EVENTS)
def test_events_that_were_not_requested_end_the_run(victim: Victim, name: str) -> None:
    victim.liar.events, expected = EVENTS[name]
    status, said = victim.run(*PLAY)
    assert (status, expected in said) == (1, True), said


def test_a_server_elsewhere_names_no_addresses_on_this_machine() -> None:
    """They would be given the token."""
    info = pb.ServerInfo(addresses=["127.0.0.1:1", "unix:/run/docker.sock", "127.0.0.1:1", "10.0.0.7:2"])
    server = Server(None, info, "host.example:50551", None, Access())  # type: ignore[arg-type]
    assert own_addresses(server) == []
    assert own_addresses(server._replace(address="127.0.0.1:50551")) == ["127.0.0.1:1", "unix:/run/docker.sock"]


@pytest.mark.parametrize("method", ["runs", "leaderboard", "notes"])
@pytest.mark.parametrize("is_empty", [False, True])
def test_pages_without_end_end(victim: Victim, method: str, is_empty: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    pages = count()

    def answer(name: str) -> Any:
        message = full(ANSWERS[name])
        if name in ("ListRuns", "List", "ListNotes"):
            message.next_page_token = f"page {next(pages)}"
            for each in ("runs", "standings", "notes") if is_empty else ():
                if each in message.DESCRIPTOR.fields_by_name:
                    message.ClearField(each)
        return message

    monkeypatch.setattr(victim.liar, "answer", answer)
    monkeypatch.setattr(listing, "MAX_PAGES", 20)
    monkeypatch.setattr(notes, "MAX_PAGES", 20)
    monkeypatch.setattr(leaderboard, "MAX_STANDINGS", 20)
    arguments = {"runs": ("--state", "running", "--limit", "1000"), "leaderboard": ("--split", SPLIT), "notes": (RUN,)}
    status, said = victim.run(method, *arguments[method])
    assert (status, "without end" in said, next(pages) < 30) == (1, True, True), said


@pytest.mark.parametrize("lie", [Lie("ServerInfo", "version", text) for text in TEXTS if text], ids=str)
def test_the_conformance_suite_prints_nothing_harmful(victim: Victim, lie: Lie) -> None:
    victim.liar.lie = lie
    status, said = victim.run("conformance", "--timeout", "5", "--only", "information,runs", "--json", "rec")
    assert status == 1, said


@pytest.mark.parametrize("message", ["Run", "Observation", "Opened", "EpisodeEnded", "Report", "Image"])
def test_the_conformance_suite_survives_lies(victim: Victim, message: str) -> None:
    for lie in islice(lies(MESSAGES[message]), 0, None, 7):
        victim.liar.lie = lie
        status, said = victim.run("conformance", "--timeout", "5", "--only", "runs,steps,images")
        assert status == 1, said


@pytest.mark.filterwarnings("ignore:.*share an object")  # The array of an instruction's tokens is, on purpose.
@pytest.mark.parametrize(
    "message", ["Run", "Observation", "EpisodeStarted", "EpisodeEnded", "RunEnded", "Score", "Texts"]
)
def test_an_environment_on_a_host_raises_no_other_errors(victim: Victim, message: str) -> None:
    """The errors that its documentation names: of the client, and of Gymnasium."""
    for lie in islice(lies(MESSAGES[message]), 0, None, 3):
        victim.liar.lie = lie
        with contextlib.suppress(ArramonClientError):
            env = gymnasium.make(
                "arramon/ArraMon-v0", server=victim.address, lang="en", split=SPLIT, sensors=("rgb",), image_size=SIZE
            )
            try:
                env.reset()
                for _ in range(4):
                    if any(env.step(0)[2:4]):
                        break
            finally:
                with contextlib.suppress(ArramonClientError):
                    env.close()
        victim.look_around()
