"""Cancellation of a run while its streams play: they are closed, and no warning is logged."""

import asyncio
import logging
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from arramon_server.errors import TakenOver
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import Observed, RunEnded
from arramon_server.runs.storage.records import CANCELLED
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick, until

__all__ = ["quick"]


@pytest.fixture
def backend(database_url: str, tmp_path: Path) -> Iterator[Backend]:
    backend = Backend(tmp_path, episodes=200, url=database_url)
    with closing(backend.database):
        yield backend


def warned(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.usefixtures("quick")
def test_cancelling_in_the_playing_process_causes_no_warnings(
    backend: Backend, caplog: pytest.LogCaptureFixture
) -> None:
    """Cancellation takes many rounds, in each of which the streams act and their clocks are checked."""

    async def body() -> list[FakeStream]:
        run = backend.run()
        async with backend.engine() as engine:
            fakes = [FakeStream(engine, run, 4, f"p{number}") for number in range(3)]
            first = [await fake.observation() for fake in fakes]
            cancelling = asyncio.create_task(engine.cancel(run))
            await asyncio.sleep(0)
            for fake, seen in zip(fakes, first, strict=True):
                fake.act(seen.episode.episode_id, 0, tiny.F)
            backend.now += 10_000.0  # no clock lasts as long
            await cancelling
            await until(lambda: all(fake.closed for fake in fakes))
            return fakes

    with caplog.at_level(logging.INFO):
        fakes = asyncio.run(body())
    assert [fake.closed for fake in fakes] == [[None]] * 3
    assert all(isinstance(fake.events[-1], RunEnded) for fake in fakes)
    assert backend.journal.run("run").state == CANCELLED
    assert backend.causes() == {"FORFEITED": 200}
    assert warned(caplog) == []


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("trigger", ["a step", "a clock"])
def test_cancelling_in_another_process_causes_no_warnings(
    backend: Backend, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, trigger: str
) -> None:
    """Between two checks for runs that others have ended, a write to the journal finds out."""
    monkeypatch.setattr(Engine, "_check_for_ended_runs", lambda _: None)

    async def body() -> None:
        run = backend.run()
        async with backend.engine() as one, backend.engine() as other:
            fake = FakeStream(one, run)
            seen = await fake.observation()
            await other.cancel(run)
            if trigger == "a step":
                fake.act(seen.episode.episode_id, 0, tiny.F)
            else:
                backend.now += 10_000.0
                one.wake()
            await until(lambda: bool(fake.closed))
            (error,) = fake.closed
            assert isinstance(error, TakenOver)
            assert str(error) == "run 'run' was closed while it was played; try again to see it"
            again = FakeStream(one, run)
            await again.next(RunEnded)
            assert not [event for event in again.events if isinstance(event, Observed)]

    with caplog.at_level(logging.INFO):
        asyncio.run(body())
    assert warned(caplog) == []
    assert "run closed while it was played" in [record.getMessage() for record in caplog.records]
