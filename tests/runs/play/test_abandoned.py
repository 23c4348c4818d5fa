"""Runs whose clients stay away for longer than their bank are closed, and keep their results."""

import asyncio
from pathlib import Path

import pytest

from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.events import Observed
from arramon_server.runs.storage.run_activity import ABANDONED_SECONDS
from tests import tiny
from tests.runs.engines import CLOCKS, Backend, FakeStream, quick, until, wait_for_rounds  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick")

DAY = 86_400.0
ALLOWED = CLOCKS.step_seconds + CLOCKS.bank_seconds + ABANDONED_SECONDS


def test_a_run_that_was_never_played_is_closed(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 3)
        backend.run()
        async with backend.engine() as engine:
            await wait_for_rounds(engine)
            backend.live(ALLOWED - 2.0)
            await wait_for_rounds(engine)
            assert backend.journal.run("run").state == "RUNNING"
            backend.live(4.0)
            await until(lambda: backend.journal.run("run").state == "COMPLETE")
        assert backend.causes() == {"FORFEITED": 3}
        endings = backend.journal.endings("run")
        assert {ending.note for ending in endings} == {"the client was away for longer than the run allows"}
        assert all(value == 0.0 for ending in endings for turn in ending.scores for value in turn.values())

    asyncio.run(play())


def test_a_closed_run_is_scored_as_far_as_it_was_played(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 3)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seen = await fake.observation()
                fake.act(seen.episode.episode_id, step, action)
            await fake.observation()
            engine.leave(fake.stream)
            backend.live(ALLOWED + 4.0)
            await until(lambda: backend.journal.run("run").state == "COMPLETE")
        assert backend.causes() == {"FORFEITED": 3}
        first = backend.journal.endings("run")[0]
        assert (first.steps, first.scores[0]["CTC-0"], first.scores[1]["nDTW"]) == (4, 1.0, 0.0)

    asyncio.run(play())


def test_what_is_left_in_the_bank_is_the_time_to_come_back(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 2)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            backend.live(60.0 + 70.0)
            fake.act(seen.episode.episode_id, 0, tiny.F)
            await fake.observation()
            engine.leave(fake.stream)
            backend.live(ALLOWED - 70.0 - 2.0)
            await wait_for_rounds(engine)
            assert backend.journal.run("run").state == "RUNNING"
            backend.live(4.0)
            await until(lambda: backend.journal.run("run").state == "COMPLETE")

    asyncio.run(play())


def test_an_open_stream_keeps_a_run(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(ClockSettings(DAY, 0.0))
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            await fake.next(Observed)
            backend.live(0.9 * DAY)
            await wait_for_rounds(engine)
            engine.leave(fake.stream)
            backend.live(0.9 * DAY)
            await wait_for_rounds(engine)
            assert backend.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_a_run_without_clocks_is_never_closed(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(ClockSettings())
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            await fake.next(Observed)
            engine.leave(fake.stream)
            backend.live(1000 * DAY)
            await wait_for_rounds(engine)
        assert backend.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_two_processes_close_a_run_once(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 6)
        backend.run()
        async with backend.engine() as engine, backend.engine() as other:
            await wait_for_rounds(engine)
            backend.live(ALLOWED + 4.0)
            await until(lambda: backend.journal.run("run").state == "COMPLETE")
            ended_at = backend.journal.run("run").ended_at
            await wait_for_rounds(engine)
            await wait_for_rounds(other)
            assert backend.journal.run("run").ended_at == ended_at
        assert backend.causes() == {"FORFEITED": 6}

    asyncio.run(play())


@pytest.mark.parametrize("seconds", [30 * DAY, -30 * DAY])
def test_neither_a_downtime_of_the_server_nor_a_jump_of_the_clock_closes_a_run(tmp_path: Path, seconds: float) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        backend.run()
        async with backend.engine() as engine:
            await wait_for_rounds(engine)
        backend.wall += seconds  # no server was there
        async with backend.engine() as engine:
            await wait_for_rounds(engine)
            backend.wall += seconds
            await wait_for_rounds(engine)
            assert backend.journal.run("run").state == "RUNNING"
            backend.live(ALLOWED + 4.0)
            await until(lambda: backend.journal.run("run").state == "COMPLETE")

    asyncio.run(play())


def test_a_run_of_data_that_is_not_served_stays(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        backend.run()
        backend.split = tiny.write(tmp_path / "other", count=2)
        async with backend.engine() as engine:
            await wait_for_rounds(engine)
            backend.live(2 * ALLOWED)
            await wait_for_rounds(engine)
            assert backend.journal.run("run").state == "RUNNING"

    asyncio.run(play())
