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
from tests.runs.engines import House, Seat, quick, until

__all__ = ["quick"]


@pytest.fixture
def house(database_url: str, tmp_path: Path) -> Iterator[House]:
    house = House(tmp_path, episodes=200, url=database_url)
    with closing(house.database):
        yield house


def warned(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.usefixtures("quick")
def test_cancelling_in_the_playing_process_causes_no_warnings(house: House, caplog: pytest.LogCaptureFixture) -> None:
    """Cancellation takes many rounds, in each of which the streams act and their clocks are checked."""

    async def body() -> list[Seat]:
        run = house.run()
        async with house.engine() as engine:
            seats = [Seat(engine, run, 4, f"p{number}") for number in range(3)]
            first = [await seat.observation() for seat in seats]
            cancelling = asyncio.create_task(engine.cancel(run))
            await asyncio.sleep(0)
            for seat, seen in zip(seats, first, strict=True):
                seat.act(seen.episode.episode_id, 0, tiny.F)
            house.now += 10_000.0  # no clock lasts as long
            await cancelling
            await until(lambda: all(seat.closed for seat in seats))
            return seats

    with caplog.at_level(logging.INFO):
        seats = asyncio.run(body())
    assert [seat.closed for seat in seats] == [[None]] * 3
    assert all(isinstance(seat.events[-1], RunEnded) for seat in seats)
    assert house.journal.run("run").state == CANCELLED
    assert house.causes() == {"FORFEITED": 200}
    assert warned(caplog) == []


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("way", ["a step", "a clock"])
def test_cancelling_in_another_process_causes_no_warnings(
    house: House, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    """Between two looks for runs that others have ended, a write to the journal is what finds out."""
    monkeypatch.setattr(Engine, "_check_for_ended_runs", lambda _: None)

    async def body() -> None:
        run = house.run()
        async with house.engine() as one, house.engine() as other:
            seat = Seat(one, run)
            seen = await seat.observation()
            await other.cancel(run)
            if way == "a step":
                seat.act(seen.episode.episode_id, 0, tiny.F)
            else:
                house.now += 10_000.0
                one.wake()
            await until(lambda: bool(seat.closed))
            (error,) = seat.closed
            assert isinstance(error, TakenOver)
            assert str(error) == "run 'run' was closed while it was played; try again to see it"
            again = Seat(one, run)
            await again.next(RunEnded)
            assert not [event for event in again.events if isinstance(event, Observed)]

    with caplog.at_level(logging.INFO):
        asyncio.run(body())
    assert warned(caplog) == []
    assert "run closed while it was played" in [record.getMessage() for record in caplog.records]
