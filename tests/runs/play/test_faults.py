"""Faults of the server are contained to their episode: it is offered again, and ended after some faults."""

import asyncio
import logging
from pathlib import Path
from typing import Any

import pytest

from arramon_server.runs.play.events import EpisodeEnded, EpisodeStarted, Event, Observed, RunEnded
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.session_loader import SessionLoader
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick")


class Break:
    """Makes a method fail for one episode, a number of times or always."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, owner: type, name: str, episode_id: str, times: int) -> None:
        self.times = times
        whole = getattr(owner, name)

        def broken(this: Any, *args: Any, **more: Any) -> Any:
            named = [getattr(thing, "episode_id", None) for thing in (*args, getattr(this, "episode", None))]
            if episode_id in named and self.times > 0:
                self.times -= 1
                raise ZeroDivisionError("a defect")
            return whole(this, *args, **more)

        monkeypatch.setattr(owner, name, broken)


@pytest.mark.parametrize(
    ("owner", "name", "sensors"),
    [(SessionLoader, "begin", ()), (EpisodeSession, "apply", ()), (Observed, "with_images", ("depth",))],
)
@pytest.mark.parametrize(("times", "cause", "reoffers"), [(1, "AGENT_FINISHED", 1), (2, "AGENT_FINISHED", 2),
                                                          (99, "SERVER_FAULT", 2)])  # fmt: skip
def test_defect_affects_only_its_episode(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture,
    owner: type, name: str, sensors: tuple[str, ...], times: int, cause: str, reoffers: int,
) -> None:  # fmt: skip
    Break(monkeypatch, owner, name, "1", times)

    async def play() -> None:
        backend = Backend(tmp_path, 3)
        run = backend.run(sensors=sensors)
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, episodes=3)
            await fake.play()
        over = fake.events[-1]
        assert isinstance(over, RunEnded)
        others = {"AGENT_FINISHED": 2 if cause == "SERVER_FAULT" else 3}
        assert over.progress.causes == ({**others, "SERVER_FAULT": 1} if cause == "SERVER_FAULT" else others)
        assert over.progress.reoffers == reoffers
        causes_by_episode = {event.episode_id: event.cause for event in fake.events if isinstance(event, EpisodeEnded)}
        assert causes_by_episode == {"0": "AGENT_FINISHED", "1": cause, "2": "AGENT_FINISHED"}
        assert [e.episode_id for e in backend.journal.endings("run")] == ["0", "1", "2"]

    with caplog.at_level(logging.ERROR):
        asyncio.run(play())
    faults = [record for record in caplog.records if record.exc_info]
    assert len(faults) >= min(times, 3)
    assert all("episode 1 of run run" in record.getMessage() for record in faults)


def test_steps_before_a_fault_are_kept_and_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seen = await fake.observation()
                fake.act(seen.episode.episode_id, step, action)
            await fake.observation()
            whole = EpisodeSession.apply

            def broken(this: EpisodeSession, action: Any) -> Any:
                if len(this.actions) == 4:
                    raise ZeroDivisionError("a defect")
                return whole(this, action)

            monkeypatch.setattr(EpisodeSession, "apply", broken)
            for _ in range(3):
                fake.act("0", 4, tiny.ACTIONS[4])
                event = await fake.next(EpisodeStarted | EpisodeEnded)  # type: ignore[arg-type]
                if isinstance(event, EpisodeStarted):
                    assert event.step == 4
                    assert (await fake.observation()).state.step == 4
        (ending,) = backend.journal.endings("run")
        assert (ending.cause, ending.steps, ending.note) == ("SERVER_FAULT", 4, "the server failed on it 3 times")
        assert ending.scores[0]["CTC-0"] == 1.0

    asyncio.run(play())


def test_an_event_that_cannot_be_delivered_affects_no_other_episode(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 3)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, episodes=3)
            whole = fake.send

            def deliver(events: list[Event]) -> None:
                if any(isinstance(event, Observed) and event.episode.episode_id == "2" for event in events):
                    raise UnicodeEncodeError("utf-8", "\ud800", 0, 1, "a defect")
                whole(events)

            fake.send = deliver  # type: ignore[assignment]
            await fake.play()
        assert backend.causes() == {"AGENT_FINISHED": 2, "SERVER_FAULT": 1}

    asyncio.run(play())


def test_episodes_of_a_dead_process_are_offered_again_and_counted(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 2)
        run = backend.run()
        claims = backend.journal.pending("run")
        backend.journal.beat("dead")
        backend.journal.claim("run", claims[:1], "p", "dead")
        backend.wall += 3.0  # without a sign of life
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, episodes=2)
            await fake.play()
            assert backend.journal.progress("run").reoffers == 1

    asyncio.run(play())


def test_a_reconnection_is_not_a_reoffer(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run()
        async with backend.engine() as engine:
            first = FakeStream(engine, run)
            await first.observation()
            second = FakeStream(engine, run)  # the same player: it takes the first one's place
            assert len(first.closed) == 1
            engine.leave(second.stream)
            await FakeStream(engine, run).observation()
            assert backend.journal.progress("run").reoffers == 0

    asyncio.run(play())
