"""Cancellation of a run by one process while another one plays it."""

import asyncio
from contextlib import closing
from pathlib import Path

import pytest

from arramon_server.runs.cancellation import Canceller
from arramon_server.runs.play import forfeits as closings
from arramon_server.runs.play.events import RunEnded
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import CANCELLED
from tests.runs.engines import Backend, FakeStream, quick

__all__ = ["quick"]


@pytest.mark.usefixtures("quick")
def test_a_run_that_is_being_cancelled_never_becomes_complete(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Let the process that plays look after each portion of forfeited episodes."""
    monkeypatch.setattr(closings, "CHUNK", 1)
    backend = Backend(tmp_path, url=database_url)

    async def body() -> None:
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, 9)  # with room for more, so that it asks what is left
            await fake.observation()
            with closing(Database(backend.url)) as database:
                loop = asyncio.get_running_loop()
                end = Canceller._mark_cancelled  # called after the last portion

                def cancelled(canceller: Canceller, run_id: str) -> None:
                    asyncio.run_coroutine_threadsafe(notified(), loop).result(10)
                    end(canceller, run_id)

                async def notified() -> None:
                    while not any(isinstance(event, RunEnded) for event in fake.events):
                        engine.wake()
                        await asyncio.sleep(0.002)

                monkeypatch.setattr(Canceller, "_mark_cancelled", cancelled)
                canceller = Canceller(database, tmp_path)
                assert (await asyncio.to_thread(canceller.cancel, "run")).state == CANCELLED
        ended = next(event for event in fake.events if isinstance(event, RunEnded))
        assert ended.run.state == CANCELLED
        assert backend.causes() == {"FORFEITED": 3}

    with closing(backend.database):
        asyncio.run(body())
