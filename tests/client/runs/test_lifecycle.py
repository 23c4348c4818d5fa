"""Runs that are closed, forgotten, stalled, or whose server is away."""

import gc
import threading
import time
import weakref
from collections.abc import Iterator
from typing import Any

import pytest

from arramon_client import Run, RunClosedError, ServerUnreachableError, UsageError
from arramon_client.runs import opening
from tests.client.fake import RUN, Servicer, World, serving
from tests.client.runs.test_run import created, first


@pytest.fixture
def address(world: World) -> Iterator[str]:
    with serving(Servicer(world)) as address:
        yield address


@pytest.mark.parametrize("call", ["report", "receipt", "cancel", "wait"])
def test_calls_of_a_closed_run_say_so(address: str, call: str) -> None:
    with created(address) as run:
        episode = first(run)
    with pytest.raises(RunClosedError, match=f"run {RUN} is closed in this program; it can be resumed"):
        getattr(run, call)()
    with pytest.raises(RunClosedError):
        episode.scores()


def test_a_forgotten_run_ends_its_stream(address: str) -> None:
    before = threading.active_count()
    run = created(address)
    assert threading.active_count() > before
    forgotten = weakref.ref(run)
    del run
    gc.collect()
    assert forgotten() is None
    while any(thread.name == "arramon-run" for thread in threading.enumerate()):
        time.sleep(0.01)


def test_an_episode_keeps_its_forgotten_run_alive(address: str) -> None:
    run = created(address)
    episode = first(run)
    del run
    gc.collect()
    after = episode.act(0, 1)
    assert (after and after.step) == 1


def test_a_wait_for_an_episode_while_the_open_ones_are_not_played_is_reported(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opening, "STALL_SECONDS", 0.05)
    notices: list[str] = []
    reported = threading.Event()

    def notify(text: str) -> None:
        notices.append(text)
        reported.set()

    with created(address, parallel=2, notify=notify) as run:
        opened = [first(run), first(run)]

        def finish() -> None:
            reported.wait()
            opened[1].give_up()

        thread = threading.Thread(target=finish)
        thread.start()
        third = first(run)
        thread.join()
    assert third.episode_id == "e2"
    assert notices[0] == (
        "the next episode is awaited, but no step was taken for 0 s: play or give up the open episodes first (e0, e1), "
        "or open more at once (parallel)"
    )
    assert len(notices) == 1


def test_patience_applies_to_resuming() -> None:
    notices: list[str] = []
    with pytest.raises(ServerUnreachableError, match=f"--resume {RUN}"):
        Run.resume(RUN, server="unix:/nonexistent/socket", patience=0.1, notify=notices.append)
    assert len(notices) == 1


def test_arguments_are_those_of_the_command_line(address: str, world: World) -> None:
    values: dict[str, Any] = {"a": True, "b": None, "c": 1.5, "d": [1, 2], "e": "x", "f": "4"}
    with created(address, agent_arguments=values):
        pass
    assert [each.value for each in world.requests[0].agent_arguments] == ["true", "null", "1.5", "[1, 2]", "x", "4"]
    with pytest.raises(UsageError, match="the agent's argument a is neither text nor a JSON value: "):
        created(address, agent_arguments={"a": {1}})


def test_the_reason_of_giving_up_is_text(address: str, world: World) -> None:
    with created(address) as run, pytest.raises(UsageError, match="the reason is 5, expected text"):
        first(run).give_up(5)  # type: ignore[arg-type]
    assert world.reasons == {}
