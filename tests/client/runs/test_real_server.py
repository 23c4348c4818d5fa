"""Runs and agents that wait on a real server: scores, receipts, restarts, clocks, several processes."""

import asyncio
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from arramon.v1.chain import episode_head
from arramon_client import AsyncRun, AsyncRunEpisode, Episode, Observation, Run, Settings, connect
from arramon_client.multi_stream import play_streams
from tests import tiny
from tests.api.player import create
from tests.relay import Relay
from tests.serving import Server

PHASES = ((0, 3), (3, 5), (5, 11), (11, 13))
"""First and last step of each phase of the ground truth."""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    tiny.write(tmp_path / "data", count=3)
    return tmp_path / "data"


@pytest.fixture
def server(data: Path, tmp_path: Path) -> Iterator[Server]:
    server = Server(data, f"unix:{tmp_path}/s", "--step-seconds", "60", "--bank-seconds", "100")
    yield server
    server.stop()


def play_phases(run: Run, sensors: tuple[str, ...]) -> Iterator[Observation | None]:
    """Play the ground truth with one plan a phase; yield what follows each."""
    for episode in run.episodes():
        for first, last in PHASES:
            seen = episode.look()
            assert seen.step == first
            assert (seen.rgb is not None, seen.pose is not None) == ("rgb" in sensors, "pose" in sensors)
            after = episode.act(first, tiny.ACTIONS[first:last])
            assert episode.stop_reason == ""
            assert episode.act(first, tiny.ACTIONS[first:last]) == after
            yield after
        assert (episode.cause, episode.actions) == ("AGENT_FINISHED", tiny.ACTIONS)


@pytest.mark.parametrize("sensors", [("rgb", "depth"), ("pose",)])
def test_scores_and_receipt_are_those_of_the_actions(server: Server, sensors: tuple[str, ...]) -> None:
    """The server is killed after each phase of the first episode, and started again."""
    with Run.create(server=server.address, language="hi", agent="mine", split="tiny", sensors=sensors) as run:
        for number, _ in enumerate(play_phases(run, sensors)):
            if number < 2:
                server.kill()
                server.start()
        info = run.wait()
        assert (info.state, info.ended, dict(info.causes)) == ("complete", 2, {"AGENT_FINISHED": 2})
        assert {row["row"]: row["CTC-0"] for row in run.report()["table"]} == dict.fromkeys(
            ("turn 1", "turn 2", "total"), 1.0
        )
        receipt = run.receipt()
    assert [episode["head"] for episode in receipt.episodes] == [
        episode_head(run.run_id, episode["episode_id"], receipt.content["data_hash"], tiny.ACTIONS).hex()
        for episode in receipt.episodes
    ]


def test_walls_block_a_plan_and_nothing_in_reach_stops_it(server: Server) -> None:
    for sensors in (("rgb", "depth"), ("pose",)):
        with Run.create(server=server.address, language="en", agent="mine", split="tiny", sensors=sensors) as run:
            episode = next(run.episodes())
            after = episode.act(0, [3, 0, 0])
            assert (after and after.step, episode.stop_reason) == (1, "no pick-up")  # Nothing is in reach.
            after = episode.act(1, tiny.ACTIONS[:3])
            assert (after and after.phase, episode.stop_reason) == ("assembly", "")
            after = episode.act(4, [0] * 10)  # The room has four rows.
            assert (after and after.step, episode.stop_reason) == (8, "blocked")
            after = episode.act(8, [1, 1, 1, 0, 3, 0])
            assert (after and after.step, after and after.turn, episode.stop_reason) == (13, 2, "phase over")
            run.cancel()
            assert (episode.ended, run.info.state) == (True, "cancelled")


def test_the_time_left_passes(server: Server) -> None:
    with Run.create(server=server.address, language="en", agent="mine", split="tiny") as run:
        seen = next(run.episodes()).look()
        first, second = seen.seconds_left(), seen.seconds_left()
        assert first is not None
        assert second is not None
        assert 0 < second <= first <= 160


class Waiting:
    """Agent that waits, and plays the ground truth."""

    sensors = ()

    def __init__(self) -> None:
        self.open: set[str] = set()
        self.asked = 0

    async def begin(self, episode: Episode) -> None:
        self.open.add(episode.episode_id)

    async def end(self, episode_id: str) -> None:
        self.open.remove(episode_id)

    async def act(self, seen: Observation) -> Any:
        self.asked += 1
        await asyncio.sleep(0)
        return tiny.ACTIONS[seen.step]


def test_an_agent_that_waits_plays_over_several_streams(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data", count=8)
    server, agent = Server(tmp_path / "data", f"unix:{tmp_path}/s", "--workers", "2"), Waiting()
    with connect(server.address) as connected:
        assert len(connected.info.addresses) == 2
        outcome = play_streams(connected, create(connected.stub), agent, Settings(parallel=4))
    assert dict(outcome.run.causes) == {"AGENT_FINISHED": 8}
    assert (agent.asked, agent.open) == (8 * len(tiny.ACTIONS), set())
    assert set(outcome.actions.values()) == {tiny.ACTIONS}
    assert server.stop() == 0


def test_connections_that_are_reset_change_no_step(data: Path) -> None:
    server, acts = Server(data), itertools.count(1)

    async def play(relay: Relay) -> None:
        async def play_one(episode: AsyncRunEpisode) -> None:
            while not episode.ended:
                seen = await episode.look()
                if next(acts) % 3 == 0:
                    relay.reset()
                await episode.act(seen.step, tiny.ACTIONS[seen.step])
            played[episode.episode_id] = episode.actions

        async with await AsyncRun.create(
            server=relay.address, language="en", agent="mine", split="tiny", sensors=()
        ) as run:
            async with asyncio.TaskGroup() as tasks:
                async for episode in run.episodes():
                    tasks.create_task(play_one(episode))
            assert (await run.wait()).steps == 3 * len(tiny.ACTIONS)
            assert {row["CTC-0"] for row in (await run.report())["table"]} == {1.0}

    played: dict[str, tuple[int, ...]] = {}
    with Relay(server.address) as relay:
        asyncio.run(play(relay))
        assert relay.resets > 6
    assert played == dict.fromkeys(("0", "1", "2"), tiny.ACTIONS)
    assert server.stop() == 0


def test_an_embedded_server_is_restarted(data: Path) -> None:
    with Run.create(data=data, language="en", agent="mine", split="tiny", sensors=(), episodes=1) as run:
        episode = next(run.episodes())
        episode.act(0, tiny.ACTIONS[:3])
        embedded: Any = run._opened.connection.revive.__self__  # type: ignore[attr-defined]
        embedded._process.kill()
        for first, last in PHASES[1:]:
            episode.act(first, tiny.ACTIONS[first:last])
        assert (episode.cause, episode.scores() is not None) == ("AGENT_FINISHED", True)
