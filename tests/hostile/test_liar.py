"""Clients that play against a server that lies, in every field of every message that it sends."""

import contextlib
import io
import re
import sys
import threading
from collections.abc import Iterator, Sequence
from itertools import cycle
from pathlib import Path

import pytest

from arramon.v1 import types_pb2
from arramon_client.cli import main
from tests.hostile.liar import (
    ANSWERS,
    RUN,
    SPLIT,
    TEXTS,
    Liar,
    Lie,
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
        assert status in (0, 1, 2, 3), (status, said)
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
        victim.liar.lie = lie
        for command in (next(commands) for _ in range(min(2, len(receive)))):
            try:
                victim.run(*command)
            except BaseException as error:
                error.add_note(f"{' '.join(command)}: {lie}")
                raise


@pytest.mark.parametrize("run_id", [text for text in TEXTS if text])
@pytest.mark.parametrize("message", ["Run", "Report", "Opened"])
def test_a_false_run_id_is_named_and_nothing_is_written(victim: Victim, run_id: str, message: str) -> None:
    victim.liar.lie = Lie("Run", "run_id", run_id)
    status, said = victim.run(*PLAY)
    assert status == 1
    assert "expected 32 hexadecimal digits" in said
    assert len(said.splitlines()) == 1
    assert [*victim.folder.joinpath("arramon-results").iterdir()] == []
