"""The time that agents take for their answers, from the server's sending to the answer's arrival."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.response_times import ResponseTimes
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick, until  # noqa: F401


def test_time_from_sending_to_the_answer_is_added_up() -> None:
    thinking = ResponseTimes()
    for step, (sent, answered) in enumerate(((10.0, 10.5), (11.0, 13.0), (13.0, 13.25))):
        thinking.send(step, sent)
        thinking.answer(step, answered)
    assert (thinking.seconds, thinking.steps) == (2.75, 3)


def test_observation_that_is_sent_again_counts_from_the_first_time() -> None:
    thinking = ResponseTimes()
    thinking.send(0, 10.0)
    thinking.send(0, 12.0)
    thinking.answer(0, 13.0)
    assert (thinking.seconds, thinking.steps) == (3.0, 1)


@pytest.mark.parametrize(
    "before",
    [lambda thinking: thinking.skip(4), lambda thinking: None, lambda thinking: thinking.send(3, 1.0)],
    ids=["sent on another stream", "never sent", "another step"],
)
def test_steps_without_a_known_start_are_left_out(before: Callable[[ResponseTimes], None]) -> None:
    thinking = ResponseTimes()
    before(thinking)
    thinking.answer(4, 20.0)
    assert (thinking.seconds, thinking.steps) == (0.0, 0)
    thinking.send(5, 20.0)
    thinking.answer(5, 21.0)
    assert (thinking.seconds, thinking.steps) == (1.0, 1)


def test_step_that_was_open_while_the_stream_broke_is_left_out() -> None:
    thinking = ResponseTimes()
    thinking.skip(4)
    thinking.send(4, 10.0)
    thinking.answer(4, 11.0)
    assert thinking.steps == 0


@pytest.mark.parametrize("clocks", [ClockSettings(), ClockSettings(60.0, 100.0)], ids=["without clocks", "with clocks"])
@pytest.mark.usefixtures("quick")
def test_engine_measures_with_and_without_clocks_and_leaves_out_what_a_stream_lost(
    tmp_path: Path, clocks: ClockSettings
) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        run = backend.run(clocks)
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            seen = await fake.observation()
            backend.now += 2.0
            fake.act(seen.episode.episode_id, 0, tiny.ACTIONS[0])
            await fake.observation()
            backend.now += 30.0
            engine.leave(fake.stream)
            fake = FakeStream(engine, run)  # gets step 1 again, whose time is lost with the stream, like that of step 0
            await fake.observation()
            backend.now += 5.0
            for step, action in enumerate(tiny.ACTIONS[1:], start=1):
                fake.act(seen.episode.episode_id, step, action)
                if step < len(tiny.ACTIONS) - 1:
                    await fake.observation()
                    backend.now += 0.5
            await until(lambda: backend.journal.progress("run").ended == 1)
        progress = backend.journal.progress("run")
        assert progress.timed_steps == len(tiny.ACTIONS) - 2
        assert progress.thinking_seconds == pytest.approx(0.5 * progress.timed_steps)
        assert progress.seconds_a_step == pytest.approx(0.5)

    asyncio.run(play())
