"""Processes killed and connections reset at moments all over a call: no step is taken twice, and none is lost."""

import asyncio
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from mcp import Client

from arramon_client.world import Action
from tests import tiny
from tests.client.mcp.players import Player
from tests.client.mcp.processes import START, STEPS, HttpProcess, StdioProcess, check_same
from tests.moments import spread_moments
from tests.relay import Relay
from tests.serving import Server

LATEST = 0.05
"""Longest time in seconds between an act and its interruption: some are hit before, some while, some after."""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=3)
    server = Server(tmp_path / "data", "127.0.0.1:0", "--steps", str(STEPS), log=tmp_path / "server.log")
    yield server
    assert server.stop() == 0


class Interruptions:
    """Interruptions of a player, each within LATEST seconds of an act."""

    def __init__(self, number: int, interrupt: Callable[[], None]) -> None:
        self.left = number
        self._interrupt = interrupt
        self._moments = iter(spread_moments(number, LATEST, seed=number))
        self._latest: asyncio.Task[None] | None = None

    async def before_act(self) -> None:
        if self.left > 0 and (self._latest is None or self._latest.done()):
            self.left -= 1
            self._latest = asyncio.create_task(self._later(next(self._moments)))
        if self._latest is not None and self._latest.done():
            self._latest.result()

    async def _later(self, seconds: float) -> None:
        await asyncio.sleep(seconds)
        await asyncio.to_thread(self._interrupt)


def play(server: Server, connect: Callable[[], Client], number: int, interrupt: Callable[[], None]) -> None:
    interruptions = Interruptions(number, interrupt)

    async def run_and_play(player: Player) -> str:
        run: str = (await player.data("start", **START))["run"]["id"]
        await player.play(run, interruptions.before_act)
        return run

    async def all_runs() -> list[tuple[str, Player]]:
        played = []
        while True:
            async with Player(connect) as player:
                played.append((await run_and_play(player), player))
            if interruptions.left == 0:
                return played

    played = asyncio.run(all_runs())
    assert sum(player.repeated for _, player in played) > 0, "no call was interrupted"
    for run, player in played:
        check_same(server, run, player)


@pytest.mark.parametrize(
    ("mode", "number"),
    [("auto", 5), pytest.param("auto", 16, marks=pytest.mark.slow), pytest.param("legacy", 8, marks=pytest.mark.slow)],
)
def test_killed_processes_take_no_step_twice(server: Server, mode: str, number: int) -> None:
    process = HttpProcess(server.address)
    play(server, lambda: Client(process.url, mode=mode, read_timeout_seconds=60), number, process.restart)
    assert process.stop() == 143


@pytest.mark.parametrize(
    ("mode", "number"),
    [("auto", 5), pytest.param("auto", 10, marks=pytest.mark.slow), pytest.param("legacy", 8, marks=pytest.mark.slow)],
)
def test_reset_connections_take_no_step_twice(server: Server, mode: str, number: int) -> None:
    process = HttpProcess(server.address)
    with Relay(process.address) as relay:
        url = f"http://{relay.address}/mcp"
        play(server, lambda: Client(url, mode=mode, read_timeout_seconds=60), number, relay.reset)
    assert process.stop() == 143


@pytest.mark.slow
def test_killed_processes_of_a_host_take_no_step_twice(server: Server, tmp_path: Path) -> None:
    process = StdioProcess(tmp_path, "--server", server.address)
    play(server, lambda: Client(process.parameters, read_timeout_seconds=60), 8, process.restart)


def test_acts_of_a_run_that_is_over_are_answered_again_by_another_process(server: Server) -> None:
    """The answer to the last one may have been lost with the process that was asked."""
    process = HttpProcess(server.address)

    async def play() -> None:
        async with Player(lambda: Client(process.url, read_timeout_seconds=60)) as player:
            run: str = (await player.data("start", **START))["run"]["id"]
            await player.play(run)
            process.restart()
            for episode, actions in player.acts.items():
                last = {"step": len(actions) - 1, "actions": [Action(actions[-1]).name]}
                again = await player.data("act", run=run, episode=episode, **last, images=[])
                assert (again["taken"], again["episode"]["ended"]) == (1, True)

    asyncio.run(play())
    assert process.stop() == 143
