"""Agents that wait: episodes at their own pace, failures of single episodes, retries, stops and resumption."""

import asyncio
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import (
    AgentError,
    AgentStoppedError,
    Answer,
    Observation,
    Outcome,
    RunInfo,
    ServerUnreachableError,
    Settings,
    StopRun,
    UsageError,
    async_play,
    connect,
    play,
    play_async,
)
from arramon_client.transport.connection import Server
from tests.client.fake import RUN, Recorder, Servicer, World, serving
from tests.client.test_play import BY_RULE, EVERYTHING, MOVED, half_played


@pytest.fixture(autouse=True)
def no_delays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(async_play, "FIRST_DELAY", 0.0)


class Waiting:
    """An agent that plays by the rule of `Recorder`, and records its calls."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Any]] = []
        self.asked: list[tuple[str, int]] = []

    async def open(self, run: RunInfo) -> None:
        self.calls.append(("open", run.run_id))

    async def close(self) -> None:
        self.calls.append(("close", None))

    def begin(self, episode: Any) -> None:
        self.calls.append(("begin", episode.episode_id))

    async def end(self, episode_id: str) -> None:
        self.calls.append(("end", episode_id))

    async def act(self, seen: Observation) -> Any:
        self.asked.append((seen.episode_id, seen.step))
        await asyncio.sleep(0)
        return Recorder.rule(seen.episode_id, seen.step)


class Replaying(Waiting):
    """An agent that is shown recorded steps."""

    def __init__(self) -> None:
        super().__init__()
        self.replayed: list[tuple[str, int, int, str | None]] = []

    def replay(self, seen: Observation, action: int) -> None:
        assert seen.taken == action
        self.replayed.append((seen.episode_id, seen.step, action, seen.taken_note))


def played(server: Server, run: pb.Run, agent: Any, **settings: Any) -> tuple[Outcome, list[str]]:
    notices: list[str] = []
    chosen = Settings(**{"parallel": 4, **settings})
    return play(server.stub, run, agent, chosen, address=server.address, notify=notices.append), notices


@pytest.mark.parametrize("parallel", [1, 3, 4])
@pytest.mark.parametrize("cut", [{}, {1: "before"}, {20: "after"}, {2: "after", 3: "before", 9: "after", 14: "before"}])
def test_every_step_is_asked_once_and_recorded(
    server: Server, world: World, run: pb.Run, parallel: int, cut: dict[int, str]
) -> None:
    world.cut = cut
    agent = Waiting()
    outcome, notices = played(server, run, agent, parallel=parallel)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert (outcome.steps, outcome.failures, outcome.reconnections) == (20, (), len(cut))
    assert outcome.run.state == pb.RUN_STATE_COMPLETE
    assert (agent.calls[0], agent.calls[-1]) == (("open", RUN), ("close", None))
    for episode_id in BY_RULE:
        assert [call for call, value in agent.calls if value == episode_id] == ["begin", "end"]
    if not cut:
        assert {episode_id: list(sent) for episode_id, sent in outcome.actions.items()} == BY_RULE
        assert notices == []


@pytest.mark.parametrize("unopened", MOVED)
def test_streams_that_reach_a_draining_process_move_without_a_word(
    server: Server, world: World, run: pb.Run, unopened: list[grpc.StatusCode | None]
) -> None:
    world.unopened = list(unopened)
    outcome, notices = played(server, run, Waiting())
    assert (world.actions, outcome.reconnections, notices) == (BY_RULE, len(unopened), [])


def test_a_slow_call_holds_up_no_other_episode(server: Server, world: World, run: pb.Run) -> None:
    class Slow(Waiting):
        async def act(self, seen: Observation) -> Any:
            if (seen.episode_id, seen.step) == ("e0", 1):
                while len(world.causes) < 3:
                    await asyncio.sleep(0.01)
            return await super().act(seen)

    outcome, _ = played(server, run, Slow(), parallel=2)
    assert (outcome.steps, world.actions) == (20, BY_RULE)


def test_it_can_be_awaited_with_any_agent(server: Server, world: World, run: pb.Run) -> None:
    async def both() -> list[Outcome]:
        first = await play_async(server, run, Waiting(), Settings(parallel=2))
        with pytest.raises(UsageError, match=r"an event loop is running: .* `await play_async"):
            play(server.stub, run, Waiting(), Settings(parallel=2))
        return [first, await play_async(server, run, Recorder(), Settings(parallel=2))]

    first, second = asyncio.run(both())
    assert (first.steps, second.steps) == (20, 0)  # The second finds the run over.


class Failing(Waiting):
    """Fails in episode e1 at step 2, as often as `failures` has entries."""

    def __init__(self, *failures: Any) -> None:
        super().__init__()
        self.failures = list(failures)

    async def act(self, seen: Observation) -> Any:
        if (seen.episode_id, seen.step) == ("e1", 2) and self.failures:
            self.asked.append(("e1", 2))
            failure = self.failures.pop(0)
            if isinstance(failure, Exception):
                raise failure
            return failure
        return await super().act(seen)


@pytest.mark.parametrize("failures", [[None], [ConnectionError("away")], [7, TimeoutError()], ["2", Answer(9)]])
def test_a_failed_call_is_repeated(server: Server, world: World, run: pb.Run, failures: list[Any]) -> None:
    agent = Failing(*failures)
    outcome, notices = played(server, run, agent)
    assert agent.asked.count(("e1", 2)) == 1 + len(failures)
    assert (world.actions, outcome.failures) == (BY_RULE, ())
    assert len(notices) == 1
    assert notices[0].startswith("the agent failed at step 2 of episode e1, and is asked again: ")


def test_after_its_retries_the_run_stops_and_is_resumable(server: Server, world: World, run: pb.Run) -> None:
    agent = Failing(None, None, None)
    with pytest.raises(
        AgentStoppedError, match=r"run stopped: the agent failed at step 2 of episode e1: .* act.. returned None"
    ):
        played(server, run, agent)
    assert (world.actions["e1"], world.causes, world.reasons) == ([1, 2], {}, {})
    assert agent.calls[-1] == ("close", None)
    resumed = Replaying()
    played(server, run, resumed, resume=True)
    assert world.actions == BY_RULE
    assert sorted(resumed.asked + [(episode, step) for episode, step, *_ in resumed.replayed]) == EVERYTHING


@pytest.mark.parametrize("settings", [{"on_failure": "give-up"}, {"keep_going": True}])
def test_the_episode_is_given_up_on_request(
    server: Server, world: World, run: pb.Run, settings: dict[str, Any]
) -> None:
    agent = Failing(ValueError("no answer"), ValueError("no answer"))
    outcome, notices = played(server, run, agent, retries=1, **settings)
    assert world.reasons == {"e1": "act() raised ValueError: no answer"}
    assert {e: a for e, a in world.actions.items() if e != "e1"} == {e: a for e, a in BY_RULE.items() if e != "e1"}
    (failure,) = outcome.failures
    assert (failure.episode_ids, failure.message) == (("e1",), "act() raised ValueError: no answer")
    assert "raise failure" in failure.details
    assert notices[-1] == (
        "the agent failed at step 2 of episode e1, which is given up: act() raised ValueError: no answer"
    )
    assert [call for call, value in agent.calls if value == "e1"] == ["begin", "end"]


def test_an_agent_states_a_failure_without_a_traceback(server: Server, world: World, run: pb.Run) -> None:
    agent = Failing(AgentError("the endpoint is overloaded"))
    with pytest.raises(AgentStoppedError) as caught:
        played(server, run, agent, retries=0)
    assert str(caught.value) == "run stopped: the agent failed at step 2 of episode e1: the endpoint is overloaded"
    assert caught.value.details == ""


@pytest.mark.parametrize("output", [None, Path("results")])
def test_an_agent_gets_the_folder_of_the_results(
    server: Server, world: World, run: pb.Run, output: Path | None
) -> None:
    class Keeping(Waiting):
        async def open(self, run: RunInfo) -> None:
            self.output = run.output

    agent = Keeping()
    played(server, run, agent, output=output)
    assert agent.output == output


def test_a_failure_of_begin_concerns_its_episode_alone(server: Server, world: World, run: pb.Run) -> None:
    class Picky(Waiting):
        def begin(self, episode: Any) -> None:
            super().begin(episode)
            if episode.episode_id == "e2":
                raise RuntimeError("not this one")

    agent = Picky()
    played(server, run, agent, on_failure="give-up")
    assert (set(world.reasons), len(world.causes)) == ({"e2"}, 4)
    assert ("end", "e2") not in agent.calls
    world.causes.clear()


def test_a_failure_of_end_stops_the_run_or_is_reported(server: Server, world: World, run: pb.Run) -> None:
    class Stuck(Waiting):
        async def end(self, episode_id: str) -> None:
            raise KeyError("no such memory")

    outcome, _ = played(server, run, Stuck(), on_failure="give-up")
    assert [failure.episode_ids for failure in outcome.failures] == [()] * 4
    assert world.reasons == {}


def test_an_agent_stops_its_run_in_order(server: Server, world: World, run: pb.Run) -> None:
    """The call that is in flight for another episode is completed and recorded, and no further one is begun."""
    begun, stopped = asyncio.Event(), asyncio.Event()

    class Limited(Waiting):
        async def act(self, seen: Observation) -> Any:
            if (seen.episode_id, seen.step) == ("e0", 2):
                await begun.wait()
                stopped.set()
                raise StopRun("100 of 100 calls are used up")
            if (seen.episode_id, seen.step) == ("e1", 3):
                begun.set()
                await stopped.wait()
                await asyncio.sleep(0.05)
            return await super().act(seen)

    agent = Limited()
    with pytest.raises(StopRun, match="100 of 100 calls are used up"):
        played(server, run, agent, parallel=2)
    assert (world.actions["e0"], world.actions["e1"], world.causes) == (BY_RULE["e0"][:2], BY_RULE["e1"][:4], {})
    resumed = Replaying()
    played(server, run, resumed, resume=True)
    assert world.actions == BY_RULE
    assert sorted(agent.asked + resumed.asked) == EVERYTHING  # No call was repeated.


def test_a_batch_agent_stops_its_run(server: Server, world: World, run: pb.Run) -> None:
    class Limited(Recorder):
        def act(self, observations: Any) -> Any:
            if observations[0].step == 2:
                raise StopRun("enough")
            return super().act(observations)

    with pytest.raises(StopRun, match="enough"):
        played(server, run, Limited())
    assert (world.reasons, world.causes, {len(taken) for taken in world.actions.values()}) == ({}, {}, {2})


def test_recorded_steps_are_replayed_and_never_asked(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)
    world.notes = {("e0", 1): "at the corner"}
    world.cut = {3: "before", 6: "after"}
    agent = Replaying()
    outcome, _ = played(server, run, agent, resume=True)
    assert agent.replayed == [("e0", 0, 0, None), ("e0", 1, 1, "at the corner"), ("e0", 2, 2, None), ("e1", 0, 1, None)]
    assert sorted(agent.asked) == sorted({*EVERYTHING} - {("e0", 0), ("e0", 1), ("e0", 2), ("e1", 0)})
    assert (outcome.steps, world.actions) == (16, BY_RULE)


def test_without_replay_recorded_steps_are_asked_again(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)
    world.actions["e0"] = [3, 3, 3]
    agent = Waiting()
    _, notices = played(server, run, agent, resume=True)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions["e0"] == [3, 3, 3, 3, 0]
    assert [notice for notice in notices if "not deterministic" in notice] == [
        "the agent is not deterministic: at step 0 of episode e0 it took "
        "3 before, but now 0; its state may differ from the original one"
    ]


def test_batch_agents_replay_too(server: Server, world: World, run: pb.Run) -> None:
    class Batch(Recorder):
        replayed: list[tuple[str, int, int]] = []  # noqa: RUF012 - of this test alone

        def replay(self, seen: Observation, action: int) -> None:
            self.replayed.append((seen.episode_id, seen.step, action))

    half_played(world)
    agent = Batch()
    played(server, run, agent, resume=True)
    assert sorted(agent.replayed) == [("e0", 0, 0), ("e0", 1, 1), ("e0", 2, 2), ("e1", 0, 1)]
    assert sorted(agent.asked) == sorted({*EVERYTHING} - {("e0", 0), ("e0", 1), ("e0", 2), ("e1", 0)})
    assert world.actions == BY_RULE


@pytest.mark.parametrize("is_async", [True, False])
def test_answers_carry_notes(server: Server, world: World, run: pb.Run, is_async: bool) -> None:
    """A note that is too long is not sent, and the participant is notified once."""

    def answer(seen: Observation) -> Answer:
        note = {"step": seen.step} if seen.step < 3 else "x" * 2049
        return Answer(Recorder.rule(seen.episode_id, seen.step), note)

    class Batch(Recorder):
        def act(self, observations: Any) -> Any:
            return [answer(seen) for seen in observations]

    class Single(Waiting):
        async def act(self, seen: Observation) -> Answer:
            return answer(seen)

    outcome, notices = played(server, run, Single() if is_async else Batch())
    assert world.actions == BY_RULE
    assert world.notes == {(e, step): f'{{"step":{step}}}' for e in BY_RULE for step in range(3)}
    assert len(notices) == len(outcome.problems) == 1
    assert notices[0] == (
        "the agent's note was not stored: a note has 2049 bytes in UTF-8, expected at most 2048; the action was taken "
        "all the same, and the run goes on"
    )


def test_a_refused_note_is_said_once_and_the_run_goes_on(server: Server, world: World, run: pb.Run) -> None:
    original = world.act

    def act(act: pb.Act, opening: pb.Open) -> list[pb.Event]:
        events = original(act, opening)
        refused = pb.Problem(code=pb.Problem.CODE_NOTE_REFUSED, message="full", episode_id=act.episode_id)
        return [pb.Event(problem=refused), *events] if act.note else events

    world.act = act  # type: ignore[method-assign]

    class Noting(Recorder):
        def act(self, observations: Any) -> Any:
            return [Answer(action, "a note") for action in super().act(observations)]

    outcome, notices = played(server, run, Noting())
    assert (world.actions, len(outcome.problems)) == (BY_RULE, 1)
    assert notices == [
        "the server did not store a note: full (episode e0, step 0); the action was taken all the same, and the run "
        "goes on"
    ]


def test_an_unreachable_server_is_given_up(world: World, run: pb.Run) -> None:
    class Away(Waiting):
        async def act(self, seen: Observation) -> Any:
            if not self.asked:
                context.__exit__(None, None, None)
            return await super().act(seen)

    context = serving(Servicer(world))
    agent = Away()
    with connect(context.__enter__()) as server, pytest.raises(ServerUnreachableError, match=f"--resume {RUN}"):
        played(server, run, agent, patience=0.3)
    assert agent.calls[-1] == ("close", None)


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"on_failure": "forfeit"}, "on_failure is 'forfeit', expected one of stop, give-up"), ({"retries": -1}, "-1")],
)
def test_wrong_settings(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        Settings(parallel=1, **settings)


AGENT = """
import asyncio
class Agent:
    sensors = ()
    def begin(self, episode): pass
    async def act(self, seen):
        with open("calls", "a") as calls:
            calls.write(f"{seen.episode_id} {seen.step}\\n")
        await asyncio.sleep(0.01)
        return (int(seen.episode_id[1:]) + seen.step) % 4
    def replay(self, seen, action): pass
"""


@pytest.mark.parametrize("calls", [1, 9])
def test_a_killed_client_repeats_only_calls_in_flight(world: World, tmp_path: Path, calls: int) -> None:
    (tmp_path / "paid.py").write_text(AGENT)
    made = tmp_path / "calls"
    with serving(Servicer(world)) as address:
        command = [sys.executable, "-m", "arramon_client", "--agent", "./paid.py", "--lang", "en", "--server", address]
        with subprocess.Popen([*command, "--parallel", "3"], cwd=tmp_path, stderr=subprocess.DEVNULL) as client:
            while not made.exists() or len(made.read_text().splitlines()) < calls:
                assert client.poll() is None
                time.sleep(0.002)
            client.kill()
        done = subprocess.run([*command, "--resume", RUN], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    paid = made.read_text().splitlines()
    assert sorted(set(paid)) == [f"{episode} {step}" for episode, step in EVERYTHING]
    assert len(paid) - len(EVERYTHING) <= 3
    assert world.actions == BY_RULE
