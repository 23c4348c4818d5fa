"""People who wait for each answer are served before agents, and agents still take their turns."""

import asyncio
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from arramon_client.world import Action
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import Event, Observed
from arramon_server.runs.storage.records import Run
from tests.runs.engines import Backend, FakeStream, until

PEOPLE, AGENTS = ("person",), ("a", "b", "c")


class RestlessStream(FakeStream):
    """A stream that answers each observation at once, and notes in a list, common to all, that it was served."""

    def __init__(self, engine: Engine, run: Run, player: str, served: list[str]) -> None:
        self._served = served
        super().__init__(engine, run, 1, player)
        self.stream.is_interactive = player in PEOPLE

    def send(self, events: Sequence[Event]) -> None:
        super().send(events)
        for event in events:
            if isinstance(event, Observed):
                self._served.append(self.stream.player)
                self.act(event.episode.episode_id, event.state.step, Action.LEFT)


def test_people_come_first_and_no_agent_starves(tmp_path: Path) -> None:
    served: list[str] = []

    async def play() -> None:
        backend = Backend(tmp_path, len(AGENTS) + len(PEOPLE))
        async with backend.engine() as engine:
            run = backend.run()
            for player in (*AGENTS, *PEOPLE):
                RestlessStream(engine, run, player, served)
            await until(lambda: len(served) > 60)

    asyncio.run(asyncio.wait_for(play(), 60))
    steady = served[served.index("person") + 8 : 60]
    agents = [player for player in steady if player in AGENTS]
    assert steady.count("person") >= len(agents) - 1  # The person is served between any two agents.
    assert all("person" in pair for pair in pairwise(steady))
    assert all(set(agents[i : i + 3]) == set(AGENTS) for i in range(len(agents) - 2))


def test_agents_alone_share_each_round(tmp_path: Path) -> None:
    served: list[str] = []

    async def play() -> None:
        backend = Backend(tmp_path, len(AGENTS))
        async with backend.engine() as engine:
            run = backend.run()
            for player in AGENTS:
                RestlessStream(engine, run, player, served)
            await until(lambda: len(served) > 30)

    asyncio.run(asyncio.wait_for(play(), 60))
    steady = served[9:30]
    assert all(set(steady[i : i + 3]) == set(AGENTS) for i in range(len(steady) - 2))
