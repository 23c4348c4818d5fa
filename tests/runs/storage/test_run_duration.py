"""End times of runs that were played while the wall clock jumped."""

import asyncio
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from arramon_server.runs.storage.records import COMPLETE, Run
from tests.runs.engines import Backend, FakeStream, quick, until

__all__ = ["quick"]

HOUR = 3600.0


@pytest.fixture
def backend(tmp_path: Path) -> Iterator[Backend]:
    backend = Backend(tmp_path)
    with closing(backend.database):
        yield backend


def duration(backend: Backend) -> timedelta:
    run = backend.journal.run("run")
    assert run.state == COMPLETE
    assert run.ended_at is not None
    return run.ended_at - run.created_at


@pytest.mark.parametrize("jump", [3 * HOUR, -3 * HOUR, 0.0])
@pytest.mark.usefixtures("quick")
def test_run_duration_ignores_wall_clock_jumps(backend: Backend, jump: float) -> None:
    async def body(run: Run) -> None:
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            await fake.observation()
            backend.wall += jump
            backend.now += 20.0
            fake = FakeStream(engine, run)  # its client comes back
            backend.now += 7.0
            await fake.play()

    asyncio.run(body(backend.run()))
    assert duration(backend).total_seconds() == pytest.approx(27.0, abs=1e-3)


@pytest.mark.usefixtures("quick")
def test_run_ended_by_another_process_never_ends_before_its_start(backend: Backend) -> None:
    """A process that has not seen the start of the run has only the wall clock."""

    async def body(run: Run) -> None:
        async with backend.engine() as engine:
            backend.wall -= HOUR
            await engine.cancel(run)
            await until(lambda: backend.journal.run("run").ended_at is not None)

    asyncio.run(body(backend.run()))
    run = backend.journal.run("run")
    assert run.ended_at == run.created_at
