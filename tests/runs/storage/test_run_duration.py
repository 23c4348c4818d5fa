"""End times of runs that were played while the wall clock jumped."""

import asyncio
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from arramon_server.runs.storage.records import COMPLETE, Run
from tests.runs.engines import House, Seat, quick, until

__all__ = ["quick"]

HOUR = 3600.0


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    house = House(tmp_path)
    with closing(house.database):
        yield house


def duration(house: House) -> timedelta:
    run = house.journal.run("run")
    assert run.state == COMPLETE
    assert run.ended_at is not None
    return run.ended_at - run.created_at


@pytest.mark.parametrize("jump", [3 * HOUR, -3 * HOUR, 0.0])
@pytest.mark.usefixtures("quick")
def test_run_duration_ignores_wall_clock_jumps(house: House, jump: float) -> None:
    async def body(run: Run) -> None:
        async with house.engine() as engine:
            seat = Seat(engine, run)
            await seat.observation()
            house.wall += jump
            house.now += 20.0
            seat = Seat(engine, run)  # its client comes back
            house.now += 7.0
            await seat.play()

    asyncio.run(body(house.run()))
    assert duration(house).total_seconds() == pytest.approx(27.0, abs=1e-3)


@pytest.mark.usefixtures("quick")
def test_run_ended_by_another_process_never_ends_before_its_start(house: House) -> None:
    """A process that has not seen the start of the run has only the wall clock."""

    async def body(run: Run) -> None:
        async with house.engine() as engine:
            house.wall -= HOUR
            await engine.cancel(run)
            await until(lambda: house.journal.run("run").ended_at is not None)

    asyncio.run(body(house.run()))
    run = house.journal.run("run")
    assert run.ended_at == run.created_at
