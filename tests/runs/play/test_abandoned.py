"""Runs whose clients stay away for longer than their bank are closed, and keep their results."""

import asyncio
from pathlib import Path

import pytest

from arramon_server.runs.play.clocks import Clocks
from arramon_server.runs.play.events import Observed
from arramon_server.runs.storage.run_activity import ABANDONED_SECONDS
from tests import tiny
from tests.runs.engines import CLOCKS, House, Seat, looks, quick, until  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick")

DAY = 86_400.0
ALLOWED = CLOCKS.step_seconds + CLOCKS.bank_seconds + ABANDONED_SECONDS


def test_a_run_that_was_never_played_is_closed(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 3)
        house.run()
        async with house.engine() as engine:
            await looks(engine)
            house.live(ALLOWED - 2.0)
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"
            house.live(4.0)
            await until(lambda: house.journal.run("run").state == "COMPLETE")
        assert house.causes() == {"FORFEITED": 3}
        endings = house.journal.endings("run")
        assert {ending.note for ending in endings} == {"the client was away for longer than the run allows"}
        assert all(value == 0.0 for ending in endings for turn in ending.scores for value in turn.values())

    asyncio.run(play())


def test_a_closed_run_is_scored_as_far_as_it_was_played(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 3)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seen = await seat.observation()
                seat.act(seen.episode.episode_id, step, action)
            await seat.observation()
            engine.leave(seat.stream)
            house.live(ALLOWED + 4.0)
            await until(lambda: house.journal.run("run").state == "COMPLETE")
        assert house.causes() == {"FORFEITED": 3}
        first = house.journal.endings("run")[0]
        assert (first.steps, first.scores[0]["CTC-0"], first.scores[1]["nDTW"]) == (4, 1.0, 0.0)

    asyncio.run(play())


def test_what_is_left_in_the_bank_is_the_time_to_come_back(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 2)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            house.live(60.0 + 70.0)
            seat.act(seen.episode.episode_id, 0, tiny.F)
            await seat.observation()
            engine.leave(seat.stream)
            house.live(ALLOWED - 70.0 - 2.0)
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"
            house.live(4.0)
            await until(lambda: house.journal.run("run").state == "COMPLETE")

    asyncio.run(play())


def test_an_open_stream_keeps_a_run(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run(Clocks(DAY, 0.0))
        async with house.engine() as engine:
            seat = Seat(engine, run)
            await seat.next(Observed)
            house.live(0.9 * DAY)
            await looks(engine)
            engine.leave(seat.stream)
            house.live(0.9 * DAY)
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_a_run_without_clocks_is_never_closed(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run(Clocks())
        async with house.engine() as engine:
            seat = Seat(engine, run)
            await seat.next(Observed)
            engine.leave(seat.stream)
            house.live(1000 * DAY)
            await looks(engine)
        assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_two_processes_close_a_run_once(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 6)
        house.run()
        async with house.engine() as engine, house.engine() as other:
            await looks(engine)
            house.live(ALLOWED + 4.0)
            await until(lambda: house.journal.run("run").state == "COMPLETE")
            ended_at = house.journal.run("run").ended_at
            await looks(engine)
            await looks(other)
            assert house.journal.run("run").ended_at == ended_at
        assert house.causes() == {"FORFEITED": 6}

    asyncio.run(play())


@pytest.mark.parametrize("seconds", [30 * DAY, -30 * DAY])
def test_neither_a_downtime_of_the_server_nor_a_jump_of_the_clock_closes_a_run(tmp_path: Path, seconds: float) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        house.run()
        async with house.engine() as engine:
            await looks(engine)
        house.wall += seconds  # no server was there
        async with house.engine() as engine:
            await looks(engine)
            house.wall += seconds
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"
            house.live(ALLOWED + 4.0)
            await until(lambda: house.journal.run("run").state == "COMPLETE")

    asyncio.run(play())


def test_a_run_of_data_that_is_not_served_stays(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        house.run()
        house.split = tiny.write(tmp_path / "other", count=2)
        async with house.engine() as engine:
            await looks(engine)
            house.live(2 * ALLOWED)
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())
