"""Idle runs are closed after the time that the host sets, and keep their results."""

import asyncio
from pathlib import Path

import pytest

from server.runs.play.events import Observed
from tests import tiny
from tests.runs.engines import House, Seat, looks, quick, until  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick")

DAY = 86_400.0


def test_a_run_that_was_never_played_is_closed(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 3)
        house.run()
        async with house.engine(idle_seconds=DAY) as engine:
            house.wall += DAY - 2.0
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"
            house.wall += 4.0
            await until(lambda: house.journal.run("run").state == "COMPLETE")
        assert house.causes() == {"FORFEITED": 3}
        endings = house.journal.endings("run")
        assert {ending.note for ending in endings} == {"the run was not played for 86400 seconds"}
        assert all(value == 0.0 for ending in endings for turn in ending.scores for value in turn.values())

    asyncio.run(play())


def test_a_closed_run_is_scored_as_far_as_it_was_played(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 3)
        run = house.run()
        async with house.engine(idle_seconds=DAY) as engine:
            seat = Seat(engine, run)
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seen = await seat.observation()
                seat.act(seen.episode.episode_id, step, action)
            await seat.observation()
            engine.leave(seat.stream)
            house.wall += DAY + 4.0
            await until(lambda: house.journal.run("run").state == "COMPLETE")
        assert house.causes() == {"FORFEITED": 3}
        first = house.journal.endings("run")[0]
        assert (first.steps, first.scores[0]["CTC-0"], first.scores[1]["nDTW"]) == (4, 1.0, 0.0)

    asyncio.run(play())


def test_an_open_stream_keeps_a_run_however_little_it_does(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run()
        async with house.engine(idle_seconds=DAY) as engine:
            seat = Seat(engine, run)
            await seat.next(Observed)
            for _ in range(4):
                house.wall += 0.9 * DAY
                noted = house.wall
                await until(lambda: (house.journal.run("run").active_at or 0.0) >= noted)  # noqa: B023
            assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_nothing_is_closed_where_the_host_sets_no_limit(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        house.run()
        async with house.engine() as engine:
            house.wall += 1000 * DAY
            await looks(engine)
        assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())


def test_two_processes_close_a_run_once(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 6)
        house.run()
        async with house.engine(idle_seconds=DAY) as engine, house.engine(idle_seconds=DAY) as other:
            house.wall += DAY + 4.0
            await until(lambda: house.journal.run("run").state == "COMPLETE")
            ended_at = house.journal.run("run").ended_at
            await looks(engine)
            await looks(other)
            assert house.journal.run("run").ended_at == ended_at
        assert house.causes() == {"FORFEITED": 6}

    asyncio.run(play())


def test_a_downtime_of_the_server_closes_no_run(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        house.run()
        house.wall += 30 * DAY  # no server was there
        async with house.engine(idle_seconds=7 * DAY) as engine:
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"
            house.wall += DAY + 4.0
            await until(lambda: house.journal.run("run").state == "COMPLETE")

    asyncio.run(play())


def test_a_run_of_data_that_is_not_served_stays(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        house.run()
        house.split = tiny.write(tmp_path / "other", count=2)
        async with house.engine(idle_seconds=DAY) as engine:
            house.wall += 2 * DAY
            await looks(engine)
            assert house.journal.run("run").state == "RUNNING"

    asyncio.run(play())
