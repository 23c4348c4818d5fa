"""Enforcement of the clocks by an engine."""

import asyncio
from pathlib import Path

import pytest

from arramon_server.runs.play.clocks import Clocks, TimeLeft
from arramon_server.runs.play.events import ActionProblem, EpisodeEnded, Observed, PhaseOver, RunEnded
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.storage.service_clock import LONGEST_TICK
from arramon_server.sim.rules import Limits
from tests import tiny
from tests.runs.engines import House, Seat, looks, quick, until  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick")


def left(seen: Observed) -> tuple[float, float]:
    """Return the seconds left of the step and of the bank."""
    assert seen.time_left is not None
    return seen.time_left.step_seconds, seen.time_left.bank_seconds


class Free:
    """Ground without obstacles."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        return True


def test_every_observation_has_the_time_left(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            assert seen.time_left == TimeLeft(60.0, 100.0)
            house.now += 110.0
            seat.act(seen.episode.episode_id, 0, tiny.F)
            assert (await seat.observation()).time_left == TimeLeft(60.0, 50.0)
        assert house.journal.run("run").bank_left == 50.0

    asyncio.run(play())


def test_run_without_clocks_never_times_out(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run(Clocks())
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            assert seen.time_left is None
            house.now += 1e9
            seat.act(seen.episode.episode_id, 0, tiny.ACTIONS[0])
            await seat.play()
        assert house.causes() == {"AGENT_FINISHED": 1}
        assert house.journal.run("run").bank_left is None

    asyncio.run(play())


def test_running_out_of_time_ends_all_phases_with_one_cause(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 2)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            first = (await seat.observation()).episode.episode_id
            seat.act(first, 0, tiny.F)
            await seat.observation()
            house.now += 161.0
            end = await seat.ended()
            assert (end.episode_id, end.cause, end.ended) == (first, "TIME_LIMIT", 1)
            phases = [(e.phase.turn, e.phase.forced) for e in seat.events if isinstance(e, PhaseOver)]
            assert phases == [(1, True), (1, True), (2, True), (2, True)]
            # With the bank empty, the next episode goes on as long as its answers are in time.
            seen = await seat.observation()
            assert seen.time_left == TimeLeft(60.0, 0.0)
            for step, action in enumerate(tiny.ACTIONS):
                house.now += 59.0
                seat.act(seen.episode.episode_id, step, action)
                if step + 1 < len(tiny.ACTIONS):
                    await seat.observation()
            assert (await seat.ended()).cause == "AGENT_FINISHED"
            await seat.next(RunEnded)
        assert house.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 1}
        assert house.journal.run("run").state == "COMPLETE"

    asyncio.run(play())


def test_timed_out_episode_replays_from_the_journal_to_its_scores(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            episode_id = (await seat.observation()).episode.episode_id
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seat.act(episode_id, step, action)
                await seat.observation()
            house.now += 200.0
            await seat.ended()
        (ending,) = house.journal.endings("run")
        assert (ending.cause, ending.steps) == ("TIME_LIMIT", 4)
        session = EpisodeSession(house.split.episodes[episode_id], Free(), Limits(150))
        assert len(list(session.replay(house.journal.actions("run", episode_id)))) == 4
        session.run_out()
        assert [dict(turn) for turn in session.scores().turns] == ending.scores
        assert ending.scores[0]["CTC-0"] == 1.0  # what the agent did before counts
        assert ending.scores[0]["PTC"] == 0.0

    asyncio.run(play())


def test_answer_in_time_counts_despite_slow_processing(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run(Clocks(60.0, 0.0))
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            house.now += 60.0
            seat.act(seen.episode.episode_id, 0, tiny.F)
            house.now += 30.0  # before the engine comes to it
            assert (await seat.observation()).state.step == 1
        assert house.causes() == {}

    asyncio.run(play())


def test_a_late_answer_is_not_applied(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run(Clocks(60.0, 0.0))
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            house.now += 60.5
            seat.act(seen.episode.episode_id, 0, tiny.F)
            assert (await seat.ended()).cause == "TIME_LIMIT"
        assert house.journal.actions("run", seen.episode.episode_id) == []

    asyncio.run(play())


def test_clocks_run_on_while_no_stream_is_open_but_not_while_no_process_runs(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 1)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            seen = await seat.observation()
            seat.act(seen.episode.episode_id, 0, tiny.F)
            await seat.observation()
            house.now += 80.0  # twenty of them from the bank
            engine.leave(seat.stream)
            house.live(10.0)
            back = Seat(engine, run)
            assert left(await back.observation()) == pytest.approx((0.0, 70.0), abs=1e-3)
            house.live(10.0)
            back.act(seen.episode.episode_id, 1, tiny.F)
            assert left(await back.observation()) == pytest.approx((60.0, 60.0), abs=1e-3)
            house.live(25.0)
        house.now += 10_000.0
        house.wall += 7 * 86_400.0
        async with house.engine() as engine:  # another process
            again = Seat(engine, house.journal.run("run"))
            assert left(await again.observation()) == pytest.approx((35.0 - LONGEST_TICK, 60.0), abs=1e-3)
        assert house.journal.run("run").bank_left == pytest.approx(60.0)

    asyncio.run(play())


def test_a_client_that_never_reads_runs_out_of_time_in_every_episode(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 4)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run, episodes=2, reads=False)
            await seat.next(Observed)
            delivered = len(seat.events)
            house.now += 161.0
            await until(lambda: house.causes() == {"TIME_LIMIT": 2})
            house.now += 1.0  # those in their places begin as soon as they could be read
            await looks(engine)
            house.now += 58.0
            await looks(engine)
            assert house.causes() == {"TIME_LIMIT": 2}
            house.now += 2.0
            await until(lambda: house.journal.run("run").state == "COMPLETE")
            assert len(seat.events) == delivered  # nothing was drawn for it
        assert house.causes() == {"TIME_LIMIT": 4}

    asyncio.run(asyncio.wait_for(play(), 120))


def test_each_overdue_stream_drains_the_shared_bank(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 4)
        run = house.run(Clocks(60.0, 100.0))
        async with house.engine() as engine:
            one, other = Seat(engine, run, 2, "one"), Seat(engine, run, 2, "other")
            for seat in (one, one, other, other):
                await seat.observation()
            house.now += 109.0
            await until(lambda: house.journal.run("run").bank_left == pytest.approx(2.0))
            house.now += 1.5
            causes = [(await seat.ended()).cause for seat in (one, one, other, other)]
            assert causes == ["TIME_LIMIT"] * 4
        assert house.causes() == {"TIME_LIMIT": 4}

    asyncio.run(play())


def test_causes_add_up_to_the_episodes(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 6)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            late = (await seat.observation()).episode.episode_id
            house.now += 161.0
            assert (await seat.ended()).episode_id == late
            await seat.observation()
            await engine.cancel(run)
            over = await seat.next(RunEnded)
            assert isinstance(over, RunEnded)
            assert over.progress.causes == {"TIME_LIMIT": 1, "FORFEITED": 5}
            assert sum(over.progress.causes.values()) == over.progress.episodes == 6
        told = [event.cause for event in seat.events if isinstance(event, EpisodeEnded)]
        assert told == ["TIME_LIMIT"]

    asyncio.run(play())


def test_late_answer_is_ignored_and_the_end_reported_once(tmp_path: Path) -> None:
    async def play() -> None:
        house = House(tmp_path, 3)
        run = house.run()
        async with house.engine() as engine:
            seat = Seat(engine, run)
            first = (await seat.observation()).episode.episode_id
            seat.act(first, 0, tiny.F)
            await seat.observation()
            house.now += 161.0
            assert (await seat.ended()).cause == "TIME_LIMIT"
            for _ in range(2):  # the agent's answer was on its way, and is sent again
                seat.act(first, 1, tiny.F)
            await seat.play()
        told = [event.episode_id for event in seat.events if isinstance(event, EpisodeEnded)]
        assert sorted(told) == ["0", "1", "2"]
        assert not [event for event in seat.events if isinstance(event, ActionProblem)]
        assert house.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 2}

    asyncio.run(play())
