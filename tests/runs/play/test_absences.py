"""Players that disconnect: free within the bound on absences, charged to the time of the step beyond it."""

import asyncio
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from server.runs.play import absences
from server.runs.play.clocks import Bank, Clocks, StreamClock, TimeLeft
from server.runs.play.engine import Engine
from server.runs.play.events import EpisodeEnded, Observed
from server.runs.storage import run_activity
from server.runs.storage.records import AWAY_SECONDS, Run
from server.sim.rules import Action
from tests.runs.engines import House, Seat, quick, until

__all__ = ["quick"]


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    house = House(tmp_path, 1)  # on SQLite, as PostgreSQL's clock is not a test's to move
    with closing(house.database):
        yield house


@pytest.mark.parametrize(
    ("away_left", "away", "left"),
    [
        (10.0, 5000.0, TimeLeft(50.0, 100.0)),
        (0.0, 5000.0, TimeLeft(50.0, 100.0)),
        (-20.0, 5000.0, TimeLeft(30.0, 100.0)),
        (-80.0, 5000.0, TimeLeft(0.0, 70.0)),
        (-80.0, 55.0, TimeLeft(0.0, 95.0)),
        (-5000.0, 5000.0, TimeLeft(0.0, 0.0)),
    ],
)
def test_only_absence_beyond_the_bound_is_charged_to_the_step(away_left: float, away: float, left: TimeLeft) -> None:
    clock = StreamClock(Clocks(60.0, 600.0, 100.0), Bank(100.0, True, away_left), lambda: 0.0)
    clock.open("a", 10.0, away)
    assert clock.time_left("a") == left
    assert clock.take_charges() >= 100.0 - left.bank_seconds


async def hangs_up_and_comes_back(house: House, engine: Engine, run: Run, seconds: float) -> Seat:
    """Let a player see a second observation, disconnect, and reconnect after so many seconds."""
    seat = Seat(engine, run)
    first = await seat.observation()
    seat.act(first.episode.episode_id, 0, Action.LEFT)
    await seat.observation()
    engine.leave(seat.stream)
    before = house.activity.away_left("run")
    house.now += seconds
    house.wall += seconds
    await until(lambda: house.activity.away_left("run") <= before - seconds + 1.0)
    return Seat(engine, run)


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(("bound", "causes"), [(AWAY_SECONDS, {}), (50.0, {"TIME_LIMIT": 1})])
def test_thinking_without_a_stream(
    house: House, monkeypatch: pytest.MonkeyPatch, bound: float, causes: dict[str, int]
) -> None:
    monkeypatch.setattr(run_activity, "AWAY_SECONDS", bound)
    monkeypatch.setattr(absences, "FIRST_SECONDS", 0.0)
    run = house.run()

    async def play() -> None:
        async with house.engine() as engine:
            seat = await hangs_up_and_comes_back(house, engine, run, 1000.0)
            seen = await seat.observation()
            assert seen.time_left == (TimeLeft(0.0, 0.0) if causes else TimeLeft(60.0, 100.0))
            house.now += 1.0
            if causes:
                await seat.next(EpisodeEnded)
            assert house.causes() == causes

    asyncio.run(asyncio.wait_for(play(), 20))


@pytest.mark.usefixtures("quick")
def test_not_reading_a_known_observation_counts_as_absence(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(absences, "FIRST_SECONDS", 0.0)
    monkeypatch.setattr(run_activity, "AWAY_SECONDS", 1000.0)
    run = house.run()

    async def play() -> None:
        async with house.engine() as engine:
            engine.leave((await hangs_up_and_comes_back(house, engine, run, 500.0)).stream)
            slow = Seat(engine, run, reads=False)
            await slow.observation()
            assert house.activity.away_left("run") == pytest.approx(500.0, abs=5.0)
            house.now += 55.0  # each message may be read for as long as a step: a history has very many
            house.wall += 55.0
            await until(lambda: house.activity.away_left("run") <= 445.0)
            assert house.activity.bank_left("run") == 100.0

    asyncio.run(asyncio.wait_for(play(), 20))


def test_a_bank_that_is_spent_at_one_process_is_spent_at_the_other(tmp_path: Path) -> None:
    house = House(tmp_path, 2)
    run = house.run()

    async def play() -> None:
        async with house.engine() as one, house.engine() as other:
            seats = [Seat(one, run, player="a"), Seat(other, run, player="b")]
            for seat in seats:
                seen = await seat.observation()
                seat.act(seen.episode.episode_id, 0, Action.LEFT)
                await seat.observation()
            for seat, step, seconds, told in (
                (seats[0], 1, 140.0, Observed),  # 80 seconds of a bank of 100
                (seats[1], 1, 0.0, Observed),  # and 80 more
                (seats[0], 2, 61.0, Observed),  # this process learns with what it charges what the other has
                (seats[0], 3, 61.0, EpisodeEnded),
            ):
                house.now += seconds
                seat.act(next(iter(seat.stream.sessions)), step, Action.LEFT)
                await seat.next(told)
            assert house.causes() == {"TIME_LIMIT": 1}

    asyncio.run(asyncio.wait_for(play(), 20))
