"""Opening of many episodes for one stream, in portions between which others are served."""

import asyncio
from pathlib import Path

import pytest

from arramon_client.world import Action
from arramon_server.runs.play import engine as engines
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import Observed, StreamOpened
from arramon_server.runs.storage.records import CommitBatch, Run
from tests.runs.engines import Backend, FakeStream, quick, until

__all__ = ["quick"]

MANY, STEPS = 12, 149


def left(backend: Backend, engine: Engine, run: Run) -> None:
    """Let a player begin many episodes, and leave all of them a step before the end of their first phase."""
    fake = FakeStream(engine, run, MANY, "greedy")
    batch = CommitBatch()
    for claim in backend.journal.open_claims("run"):
        if claim.player == "greedy":
            for step in range(STEPS):
                batch.add_step("run", claim.episode_id, claim.fence, step, Action.LEFT)
    backend.journal.commit(batch)
    engine.leave(fake.stream)


def observed(fake: FakeStream) -> list[Observed]:
    return [event for event in fake.events if isinstance(event, Observed)]


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("history", [False, True])
def test_other_streams_are_answered_while_long_episodes_are_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, history: bool
) -> None:
    monkeypatch.setattr(engines, "OPENING_SECONDS", 0.0001)
    backend = Backend(tmp_path, MANY + 1)
    run = backend.run()

    async def play() -> None:
        async with backend.engine() as engine:
            neighbour = FakeStream(engine, run, 1, "neighbour")
            first = await neighbour.observation()
            left(backend, engine, run)
            greedy = FakeStream(engine, run, MANY, "greedy", history=history)
            neighbour.act(first.episode.episode_id, 0, Action.LEFT)
            assert (await neighbour.observation()).state.step == 1
            assert len([event for event in observed(greedy) if event.taken is None]) < MANY
            await until(lambda: len([event for event in observed(greedy) if event.taken is None]) == MANY)
            (opened,) = [event for event in greedy.events if isinstance(event, StreamOpened)]
            assert len(opened.episode_ids) == MANY
            assert {event.state.step for event in observed(greedy) if event.taken is None} == {STEPS}
            assert len(observed(greedy)) == MANY * (STEPS + 1 if history else 1)

    asyncio.run(asyncio.wait_for(play(), 60))


@pytest.mark.usefixtures("quick")
def test_unopened_episodes_are_released_with_their_waiting_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "OPENING_SECONDS", 0.0)
    backend = Backend(tmp_path, MANY)
    run = backend.run()

    async def play() -> None:
        async with backend.engine() as engine:
            greedy = FakeStream(engine, run, MANY, "greedy")
            engine.leave(greedy.stream)
            claims = backend.journal.open_claims("run")
            assert [claim.worker for claim in claims] == [None] * MANY
            backend.journal.release("run", {claim.episode_id: claim.fence for claim in claims}, {"0": (5, 7.0)})
            again = FakeStream(engine, run, MANY, "greedy")
            assert not again.stream.sessions
            engine.leave(again.stream)
            claims = backend.journal.open_claims("run")
            assert [claim.worker for claim in claims] == [None] * MANY
            waits = [claim.seconds_waited(5) for claim in claims if claim.seconds_waited(5) is not None]
            assert waits == pytest.approx([7.0])

    asyncio.run(asyncio.wait_for(play(), 60))
