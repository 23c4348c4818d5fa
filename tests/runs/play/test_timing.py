"""Enforcement of the clocks by an engine."""

import asyncio
from pathlib import Path

import pytest

from arramon_server.runs.play.clocks import ClockSettings, TimeLeft
from arramon_server.runs.play.events import ActionProblem, EpisodeEnded, Observed, PhaseFinished, RunEnded
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.storage.service_clock import LONGEST_TICK
from arramon_server.sim.rules import Limits
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick, until, wait_for_rounds  # noqa: F401

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
        backend = Backend(tmp_path)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            assert seen.time_left == TimeLeft(60.0, 100.0)
            backend.now += 110.0
            fake.act(seen.episode.episode_id, 0, tiny.F)
            assert (await fake.observation()).time_left == TimeLeft(60.0, 50.0)
        assert backend.journal.run("run").bank_left == 50.0

    asyncio.run(play())


def test_run_without_clocks_never_times_out(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(ClockSettings())
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            assert seen.time_left is None
            backend.now += 1e9
            fake.act(seen.episode.episode_id, 0, tiny.ACTIONS[0])
            await fake.play()
        assert backend.causes() == {"AGENT_FINISHED": 1}
        assert backend.journal.run("run").bank_left is None

    asyncio.run(play())


def test_running_out_of_time_ends_all_phases_with_one_cause(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 2)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            first = (await fake.observation()).episode.episode_id
            fake.act(first, 0, tiny.F)
            await fake.observation()
            backend.now += 161.0
            end = await fake.ended()
            assert (end.episode_id, end.cause, end.ended) == (first, "TIME_LIMIT", 1)
            phases = [(e.phase.turn, e.phase.forced) for e in fake.events if isinstance(e, PhaseFinished)]
            assert phases == [(1, True), (1, True), (2, True), (2, True)]
            # With the bank empty, the next episode goes on as long as its answers are in time.
            seen = await fake.observation()
            assert seen.time_left == TimeLeft(60.0, 0.0)
            for step, action in enumerate(tiny.ACTIONS):
                backend.now += 59.0
                fake.act(seen.episode.episode_id, step, action)
                if step + 1 < len(tiny.ACTIONS):
                    await fake.observation()
            assert (await fake.ended()).cause == "AGENT_FINISHED"
            await fake.next(RunEnded)
        assert backend.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 1}
        assert backend.journal.run("run").state == "COMPLETE"

    asyncio.run(play())


def test_timed_out_episode_replays_from_the_journal_to_its_scores(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            episode_id = (await fake.observation()).episode.episode_id
            for step, action in enumerate(tiny.ACTIONS[:4]):
                fake.act(episode_id, step, action)
                await fake.observation()
            backend.now += 200.0
            await fake.ended()
        (ending,) = backend.journal.endings("run")
        assert (ending.cause, ending.steps) == ("TIME_LIMIT", 4)
        session = EpisodeSession(backend.split.episodes[episode_id], Free(), Limits(150))
        assert len(list(session.replay(backend.journal.actions("run", episode_id)))) == 4
        session.end_at_time_limit()
        assert [dict(turn) for turn in session.scores().turns] == ending.scores
        assert ending.scores[0]["CTC-0"] == 1.0  # what the agent did before counts
        assert ending.scores[0]["PTC"] == 0.0

    asyncio.run(play())


def test_answer_in_time_counts_despite_slow_processing(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(ClockSettings(60.0, 0.0))
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            backend.now += 60.0
            fake.act(seen.episode.episode_id, 0, tiny.F)
            backend.now += 30.0  # before the engine comes to it
            assert (await fake.observation()).state.step == 1
        assert backend.causes() == {}

    asyncio.run(play())


def test_a_late_answer_is_not_applied(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(ClockSettings(60.0, 0.0))
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            backend.now += 60.5
            fake.act(seen.episode.episode_id, 0, tiny.F)
            assert (await fake.ended()).cause == "TIME_LIMIT"
        assert backend.journal.actions("run", seen.episode.episode_id) == []

    asyncio.run(play())


def test_clocks_run_on_while_no_stream_is_open_but_not_while_no_process_runs(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            fake.act(seen.episode.episode_id, 0, tiny.F)
            await fake.observation()
            backend.now += 80.0  # twenty of them from the bank
            engine.leave(fake.stream)
            backend.live(10.0)
            back = FakeStream(engine, run)
            assert left(await back.observation()) == pytest.approx((0.0, 70.0), abs=1e-3)
            backend.live(10.0)
            back.act(seen.episode.episode_id, 1, tiny.F)
            assert left(await back.observation()) == pytest.approx((60.0, 60.0), abs=1e-3)
            backend.live(25.0)
        backend.now += 10_000.0
        backend.wall += 7 * 86_400.0
        async with backend.engine() as engine:  # another process
            again = FakeStream(engine, backend.journal.run("run"))
            assert left(await again.observation()) == pytest.approx((35.0 - LONGEST_TICK, 60.0), abs=1e-3)
        assert backend.journal.run("run").bank_left == pytest.approx(60.0)

    asyncio.run(play())


def test_a_client_that_stops_reading_runs_out_of_time_in_every_episode(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 4)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, episodes=2)
            await fake.observation()
            await fake.observation()
            fake.reads = False
            delivered = len(fake.events)
            backend.now += 161.0
            await until(lambda: backend.causes() == {"TIME_LIMIT": 2})
            backend.now += 1.0  # those in their places begin as soon as they could be read
            await wait_for_rounds(engine)
            backend.now += 58.0
            await wait_for_rounds(engine)
            assert backend.causes() == {"TIME_LIMIT": 2}
            backend.now += 2.0
            await until(lambda: backend.journal.run("run").state == "COMPLETE")
            assert len(fake.events) == delivered  # nothing was drawn for it
        assert backend.causes() == {"TIME_LIMIT": 4}

    asyncio.run(asyncio.wait_for(play(), 120))


def test_each_overdue_stream_drains_the_shared_bank(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 4)
        run = backend.run(ClockSettings(60.0, 100.0))
        async with backend.engine() as engine:
            one, other = FakeStream(engine, run, 2, "one"), FakeStream(engine, run, 2, "other")
            for fake in (one, one, other, other):
                await fake.observation()
            backend.now += 109.0
            await until(lambda: backend.journal.run("run").bank_left == pytest.approx(2.0))
            backend.now += 1.5
            causes = [(await fake.ended()).cause for fake in (one, one, other, other)]
            assert causes == ["TIME_LIMIT"] * 4
        assert backend.causes() == {"TIME_LIMIT": 4}

    asyncio.run(play())


def test_causes_add_up_to_the_episodes(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 6)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            late = (await fake.observation()).episode.episode_id
            backend.now += 161.0
            assert (await fake.ended()).episode_id == late
            await fake.observation()
            await engine.cancel(run)
            over = await fake.next(RunEnded)
            assert isinstance(over, RunEnded)
            assert over.progress.causes == {"TIME_LIMIT": 1, "FORFEITED": 5}
            assert sum(over.progress.causes.values()) == over.progress.episodes == 6
        told = [event.cause for event in fake.events if isinstance(event, EpisodeEnded)]
        assert told == ["TIME_LIMIT"]

    asyncio.run(play())


def test_late_answer_is_ignored_and_the_end_reported_once(tmp_path: Path) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 3)
        run = backend.run()
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            first = (await fake.observation()).episode.episode_id
            fake.act(first, 0, tiny.F)
            await fake.observation()
            backend.now += 161.0
            assert (await fake.ended()).cause == "TIME_LIMIT"
            for _ in range(2):  # the agent's answer was on its way, and is sent again
                fake.act(first, 1, tiny.F)
            await fake.play()
        told = [event.episode_id for event in fake.events if isinstance(event, EpisodeEnded)]
        assert sorted(told) == ["0", "1", "2"]
        assert not [event for event in fake.events if isinstance(event, ActionProblem)]
        assert backend.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 2}

    asyncio.run(play())
