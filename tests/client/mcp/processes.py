"""Processes of `arramon-client mcp` that tests kill and start again, and the comparison of what was played."""

import os
import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from mcp import StdioServerParameters

from arramon.v1.chain import episode_head
from arramon_client import Run
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests.client.mcp.players import Player
from tests.faults.clients import journal_url
from tests.forked import ForkedClient
from tests.ports import free_port
from tests.serving import Server

STEPS = 8
"""Step limit of a phase."""

START = {"language": "en", "agent": "same", "sensors": ["pose"]}
"""Arguments of `start`; with poses a plan stops where the way is blocked, and no image is drawn."""

STDIO = """
import os, pathlib, sys
from arramon_client.cli import main
pathlib.Path(sys.argv[1]).write_text(str(os.getpid()))
sys.exit(main(["mcp", *sys.argv[2:]]))
"""


class HttpProcess:
    """`arramon-client mcp --http` on one port, over restarts."""

    def __init__(self, server: str, *more: str) -> None:
        self.address = f"127.0.0.1:{free_port()}"
        self.url = f"http://{self.address}/mcp"
        self._arguments = ["mcp", "--server", server, "--http", self.address, *more]
        self.start()

    def start(self) -> None:
        self.process = ForkedClient(self._arguments)
        said = []
        for line in self.process.stdout:
            said.append(line)
            if line.startswith("listening on "):
                return
        raise AssertionError(f"the process did not start: {said}")

    def restart(self) -> None:
        """Kill the process, and start it again."""
        self.process.kill()
        self.process.communicate()
        self.start()

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        self.process.communicate()
        assert self.process.returncode is not None
        return self.process.returncode


class StdioProcess:
    """`arramon-client mcp` as a host starts it, with the id of its latest process in a file."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self._file = folder / "process"
        self.parameters = StdioServerParameters(
            command=sys.executable, args=["-c", STDIO, str(self._file), *arguments], env=dict(os.environ)
        )

    @property
    def pid(self) -> int:
        return int(self._file.read_text())

    def restart(self) -> None:
        """Kill the process; the client starts another one."""
        with suppress(FileNotFoundError, ValueError, ProcessLookupError):  # It has not begun, or is dead already.
            os.kill(self.pid, signal.SIGKILL)


def check_same(server: Server, run: str, player: Player) -> None:
    """Check that a run is what its player counted, and has the scores and causes of the same actions over gRPC."""
    report, heads = _results(server, run)
    with closing(Database(journal_url(server.data))) as database:
        journal = Journal(database)
        recorded = {each["episode_id"]: journal.actions(run, each["episode_id"]) for each in report["episodes"]}
    assert player.acts.keys() == recorded.keys()
    for episode_id, counted in player.acts.items():
        rest = recorded[episode_id][len(counted) :]
        assert recorded[episode_id][: len(counted)] == counted
        assert rest == player.unanswered.get(episode_id, [])[: len(rest)]
    twin = _played_over_grpc(server, recorded)
    other, other_heads = _results(server, twin)
    assert report["episodes"] == other["episodes"]
    assert report["metrics"] == other["metrics"]
    for run_id, found in ((run, heads), (twin, other_heads)):
        data_hash = report["run"]["data_hash"]
        expected = {each: episode_head(run_id, each, data_hash, actions).hex() for each, actions in recorded.items()}
        assert found == expected


def _results(server: Server, run_id: str) -> tuple[dict[str, Any], dict[str, str]]:
    with Run.resume(run_id, server=server.address) as run:
        return run.report(), {episode["episode_id"]: episode["head"] for episode in run.receipt().episodes}


def _played_over_grpc(server: Server, actions: Mapping[str, Sequence[int]]) -> str:
    with Run.create(server=server.address, language="en", agent="same", sensors=("pose",)) as run:
        for episode in run.episodes():
            for step, action in enumerate(actions[episode.episode_id]):
                episode.act(step, action)
            assert episode.ended
        return run.run_id
