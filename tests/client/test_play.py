"""The play loop against a scripted server: batches, broken streams, history and failing agents."""

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import grpc
import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import (
    AgentStoppedError,
    Outcome,
    Progress,
    ProtocolError,
    ServerUnreachableError,
    Settings,
    connect,
    play,
)
from arramon_client.agent import Episode, Label
from arramon_client.plugin.failures import FAILURES_IN_A_ROW, FailureCounter
from arramon_client.session import Session
from arramon_client.transport.connection import Server
from arramon_client.transport.retry import QUIET_ATTEMPTS
from tests.client.fake import RUN, Recorder, Servicer, World, serving

EVERYTHING = [(f"e{i}", step) for i in range(4) for step in range(5)]
BY_RULE = {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}


def played(server: Server, run: pb.Run, agent: Any, **settings: Any) -> tuple[Outcome, list[str]]:
    notices: list[str] = []
    chosen = Settings(**{"parallel": 4, **settings})
    return play(server.stub, run, agent, chosen, address=server.address, notify=notices.append), notices


@pytest.mark.parametrize("parallel", [1, 3, 4, 16])
def test_every_step_is_played_once_and_recorded(server: Server, world: World, run: pb.Run, parallel: int) -> None:
    agent = Recorder()
    outcome, notices = played(server, run, agent, parallel=parallel)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert agent.begun == ["e0", "e1", "e2", "e3"]
    assert (outcome.steps, outcome.failures, outcome.reconnections, notices) == (20, (), 0, [])
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_events_that_arrive_together_are_one_batch_in_both_directions(
    server: Server, world: World, run: pb.Run
) -> None:
    agent = Recorder()
    played(server, run, agent)
    assert agent.sizes == [4] * 5
    assert world.batches == [4] * 5


def test_progress_counts_episodes_and_steps(server: Server, run: pb.Run) -> None:
    seen: list[Progress] = []
    play(server.stub, run, Recorder(), Settings(parallel=2), progress=seen.append)
    assert (seen[-1].episodes, seen[-1].ended, seen[-1].steps) == (4, 4, 20)


@pytest.mark.parametrize("cut", [
    {1: "before"}, {1: "after"}, {7: "before"}, {7: "after"}, {20: "after"}, {20: "before"},
    {2: "after", 3: "before", 9: "after", 14: "before", 15: "after"},
])  # fmt: skip
def test_cut_streams_do_not_change_the_actions(server: Server, world: World, run: pb.Run, cut: dict[int, str]) -> None:
    world.cut = cut
    agent = Recorder()
    outcome, notices = played(server, run, agent)
    assert sorted(agent.asked) == EVERYTHING
    assert agent.begun == ["e0", "e1", "e2", "e3"]
    assert world.actions == BY_RULE
    assert outcome.reconnections == len(cut)
    assert len({opening.player for opening in world.opens}) == 1
    assert "UNAVAILABLE: cut" in notices[0]


MOVED = [
    [None],
    [grpc.StatusCode.CANCELLED],
    [grpc.StatusCode.UNAVAILABLE],
    [None, grpc.StatusCode.CANCELLED],
    [grpc.StatusCode.CANCELLED, grpc.StatusCode.UNAVAILABLE],
    # Its process ends the stream, gRPC refuses it at the common address, its process is gone: the next one moves.
    [None, grpc.StatusCode.CANCELLED, grpc.StatusCode.UNAVAILABLE],
]


@pytest.mark.parametrize("unopened", MOVED)
def test_streams_that_reach_a_draining_process_move_without_a_word(
    server: Server, world: World, run: pb.Run, unopened: list[grpc.StatusCode | None]
) -> None:
    world.unopened = list(unopened)
    outcome, notices = played(server, run, Recorder())
    assert (world.actions, outcome.reconnections, notices) == (BY_RULE, len(unopened), [])


def test_a_server_that_takes_no_stream_is_reported(server: Server, world: World, run: pb.Run) -> None:
    world.unopened = [None, *[grpc.StatusCode.UNAVAILABLE] * (QUIET_ATTEMPTS - 2), grpc.StatusCode.CANCELLED]
    _, (lost, back) = played(server, run, Recorder())
    assert lost == "connection lost (CANCELLED: draining); retrying"
    assert back.startswith("reconnected after ")
    assert world.actions == BY_RULE


def test_the_client_reconnects_to_a_restarted_server(world: World, run: pb.Run, tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/s"
    half, gone = threading.Event(), threading.Event()

    class Waiting(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            if len(self.asked) >= 8 and not half.is_set():
                half.set()
                assert gone.wait(120)  # The server goes away while the agent thinks.
            return super().act(observations)

    agent = Waiting()
    outcomes: list[Outcome] = []
    first = serving(Servicer(world), address)
    first.__enter__()
    with connect(address) as server:
        player = threading.Thread(target=lambda: outcomes.append(played(server, run, agent)[0]))
        player.start()
        assert half.wait(120)
        first.__exit__(None, None, None)
        gone.set()
        with serving(Servicer(world), address):
            player.join(120)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert outcomes[0].reconnections >= 1


def test_an_unreachable_server_is_given_up_and_the_run_is_named(world: World, run: pb.Run) -> None:
    class Away(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            context.__exit__(None, None, None)
            return super().act(observations)

    context = serving(Servicer(world))
    with connect(context.__enter__()) as server, pytest.raises(ServerUnreachableError, match=f"--resume {RUN}"):
        played(server, run, Away(), patience=0.3)


def test_an_embedded_server_is_revived_before_a_retry(server: Server, world: World, run: pb.Run) -> None:
    world.cut = {3: "after", 8: "before"}
    revived: list[int] = []
    play(server.stub, run, Recorder(), Settings(parallel=4), revive=lambda: revived.append(1))
    assert len(revived) == 2


def half_played(world: World) -> None:
    world.actions = {"e0": [0, 1, 2], "e1": [1]}
    world.players = {"e0": "another", "e1": "another"}


@pytest.mark.parametrize("cut", [{}, {1: "before"}, {2: "after"}, {5: "before", 6: "after"}])
def test_resume_replays_the_history_in_order_and_sends_none_of_it(
    server: Server, world: World, run: pb.Run, cut: dict[int, str]
) -> None:
    half_played(world)
    world.cut = cut
    agent = Recorder()
    outcome, notices = played(server, run, agent, resume=True)
    assert world.opens[0].adopt
    assert world.opens[0].history
    assert sorted(agent.asked) == EVERYTHING
    assert [step for episode, step in agent.asked if episode == "e0"] == [0, 1, 2, 3, 4]
    assert world.actions == BY_RULE
    assert outcome.steps == 16
    assert not [notice for notice in notices if "deterministic" in notice]


def test_a_nondeterministic_agent_causes_one_warning(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)
    world.actions["e0"] = [3, 3, 3]
    agent = Recorder()
    outcome, notices = played(server, run, agent, resume=True)
    assert [notice for notice in notices if "not deterministic" in notice] == [
        "the agent is not deterministic: at step 0 of episode e0 it took "
        "3 before, but now 0; its state may differ from the original one"
    ]
    assert world.actions["e0"] == [3, 3, 3, 3, 0]
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_an_episode_left_by_another_player_is_replayed(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)
    original = world.opened

    def opened(opening: pb.Open) -> list[pb.Event]:
        world.players = dict.fromkeys(world.players, opening.player)  # The other's grace has passed.
        return original(opening)

    world.opened = opened  # type: ignore[method-assign]
    agent = Recorder()
    outcome, _ = played(server, run, agent)
    assert [opening.history for opening in world.opens] == [False, True]
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert outcome.steps == 16


def test_episodes_given_to_another_player_are_dropped(server: Server, world: World, run: pb.Run) -> None:
    world.cut = {6: "before"}
    original = world.opened

    def opened(opening: pb.Open) -> list[pb.Event]:
        if len(world.opens) == 1:
            world.players["e0"] = "another"
            world.causes["e0"] = types_pb2.CAUSE_TIME_LIMIT
        return original(opening)

    world.opened = opened  # type: ignore[method-assign]
    agent = Recorder()
    outcome, _ = played(server, run, agent)
    assert outcome.run.state == pb.RUN_STATE_COMPLETE
    assert [step for episode, step in agent.asked if episode == "e0"] == [0, 1]


def test_not_your_episode_problem_does_not_stop_other_episodes(server: Server, world: World, run: pb.Run) -> None:
    world.problems = {2: pb.Problem.CODE_NOT_YOUR_EPISODE}
    world.causes["e1"] = types_pb2.CAUSE_TIME_LIMIT
    world.players["e1"] = "another"
    world.actions["e1"] = []
    original = world.act

    def act(act: pb.Act, opening: pb.Open) -> list[pb.Event]:
        events = original(act, opening)
        if any(event.HasField("problem") for event in events):
            events += world.ended(act.episode_id, types_pb2.CAUSE_TIME_LIMIT, opening)
        return events

    world.act = act  # type: ignore[method-assign]
    outcome, notices = played(server, run, Recorder())
    assert outcome.problems == ("CODE_NOT_YOUR_EPISODE: no (episode e2, step 0)",)
    assert notices == ["the server reports CODE_NOT_YOUR_EPISODE: no (episode e2, step 0)"]


@pytest.mark.parametrize("code", [
    pb.Problem.CODE_STEP_AHEAD, pb.Problem.CODE_BAD_ACTION, pb.Problem.CODE_STEP_BEHIND, pb.Problem.CODE_UNSPECIFIED,
])  # fmt: skip
def test_a_protocol_violation_of_the_client_is_an_error(
    server: Server, world: World, run: pb.Run, code: pb.Problem.Code.ValueType
) -> None:
    world.problems = {3: code}
    with pytest.raises(ProtocolError, match=pb.Problem.Code.Name(code)):
        played(server, run, Recorder())


def test_a_repeated_episode_end_counts_once(server: Server, world: World, run: pb.Run) -> None:
    original = world.ended

    def ended(episode_id: str, cause: types_pb2.Cause.ValueType, opening: pb.Open) -> list[pb.Event]:
        events = original(episode_id, cause, opening)
        return [events[0], *events]

    world.ended = ended  # type: ignore[method-assign]
    outcome, _ = played(server, run, Recorder())
    assert {episode_id: list(sent) for episode_id, sent in outcome.actions.items()} == BY_RULE


def test_actions_are_recorded_only_for_episodes_played_from_start_to_end(run: pb.Run, world: World) -> None:
    """A clock may end an episode before its player has been shown all that another played of it."""
    world.actions = {"e0": [0, 1, 2], "e1": [1], "e2": []}
    known = Session(run, Recorder(), lambda _: None, FailureCounter(keep_going=False))
    known.start_stream(history=True)
    for episode_id in world.actions:
        for event in world.started(episode_id, history=True):
            known.take(event)
    known.answer()  # the first step of each: of e0 two more were played, e1 waits for its second
    for episode_id in ("e0", "e1", "e2", "e3"):
        known.take(pb.Event(episode_ended=pb.EpisodeEnded(episode_id=episode_id, cause=types_pb2.CAUSE_TIME_LIMIT)))
    assert known.actions == {"e2": (2,)}


class ActionHandler(Recorder):
    """Answers `answer` at step 2 of everything."""

    def __init__(self, answer: Any) -> None:
        super().__init__()
        self.answer = answer

    def act(self, observations: Sequence[Any]) -> Any:
        actions = super().act(observations)
        if observations[0].step != 2:
            return actions
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(("answer", "said"), [
    (None, "it returned None"),
    ([0, 1, 2], "it returned 3"),
    ([0] * 5, "it returned 5"),
    ([], "it returned 0"),
    (2, "it returned int 2"),
    ("0123", "it returned str '0123'"),
    ({0: 1, 1: 1, 2: 1, 3: 1}, "it returned dict"),
    ((i for i in range(4)), "it returned generator"),
    ([0, 1, 2, 4], "act() returned int 4; an action is 0 (forward)"),
    ([0, 1, -1, 3], "act() returned int -1"),
    ([0, 1, 2, True], "act() returned bool True"),
    ([0, 1, np.bool_(True), 0], "an action is 0 (forward)"),
    ([0, 1.0, 2, 3], "act() returned float 1.0; an action is an integer"),
    (np.zeros(4), "an action is an integer"),
    (["0", "1", "2", "3"], "act() returned str '0'"),
    (["FORWARD"] * 4, "act() returned str 'FORWARD'"),
    (ValueError("out of memory"), "act() raised ValueError: out of memory"),
    (KeyError(), "act() raised KeyError"),
    (SystemExit(1), "act() raised SystemExit"),
])  # fmt: skip
def test_an_invalid_answer_gives_up_the_batch(
    server: Server, world: World, run: pb.Run, answer: Any, said: str
) -> None:
    outcome, notices = played(server, run, ActionHandler(answer), keep_going=True)
    assert set(world.reasons) == {"e0", "e1", "e2", "e3"}
    assert all(said in reason for reason in world.reasons.values())
    assert outcome.failures[0].episode_ids == ("e0", "e1", "e2", "e3")
    assert said in notices[0]
    assert set(world.causes.values()) == {types_pb2.CAUSE_FORFEITED}


class Slipping(Recorder):
    """Fails at a step of some episodes."""

    def __init__(self, step: int, episodes: str) -> None:
        super().__init__()
        self.step, self.episodes = step, {f"e{digit}" for digit in episodes}

    def act(self, observations: Sequence[Any]) -> list[int]:
        actions = super().act(observations)
        if any(seen.step == self.step and seen.episode_id in self.episodes for seen in observations):
            return [4] * len(observations)
        return actions


NEVER, ROW = "before its first valid action", "in 3 episodes in a row"


@pytest.mark.parametrize(("parallel", "step", "failing", "when", "given_up"), [
    (1, 0, "0", NEVER, ""),
    (8, 0, "0", NEVER, ""),
    (8, 2, "3", "in 8 episodes in a row", ""),
    (1, 2, "01234567", ROW, "01"),
    (1, 2, "012", ROW, "01"),
    (1, 0, "2345", ROW, "23"),
    (1, 2, "0134567", ROW, "0134"),
    (2, 2, "01234567", "in 4 episodes in a row", "01"),
])  # fmt: skip
def test_early_or_frequent_failures_stop_the_run_which_can_be_resumed(
    parallel: int, step: int, failing: str, when: str, given_up: str
) -> None:
    world = World(episodes=8)
    run = world.create(pb.CreateRunRequest(agent="recorder", split="val_seen", language="en"))
    with serving(Servicer(world)) as address, connect(address) as server:
        with pytest.raises(AgentStoppedError, match=rf"^run stopped: the agent failed {when}: .*int 4"):
            played(server, run, Slipping(step, failing), parallel=parallel)
        assert set(world.reasons) == {f"e{digit}" for digit in given_up}
        assert world.current_run().state == pb.RUN_STATE_RUNNING
        outcome, _ = played(server, run, Recorder(), parallel=parallel, resume=True)
    assert outcome.run.state == pb.RUN_STATE_COMPLETE
    assert set(world.reasons) == {f"e{digit}" for digit in given_up}
    whole = {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(8)}
    assert {e: taken for e, taken in world.actions.items() if e not in world.reasons} == {
        e: taken for e, taken in whole.items() if e not in world.reasons
    }


@pytest.mark.parametrize("failing", ["1", "12", "1245", "02357"])
def test_occasional_failures_give_up_only_those_episodes(failing: str) -> None:
    world = World(episodes=8)
    run = world.create(pb.CreateRunRequest(agent="recorder", split="val_seen", language="en"))
    with serving(Servicer(world)) as address, connect(address) as server:
        played(server, run, Slipping(1, failing), parallel=1)
    assert set(world.reasons) == {f"e{digit}" for digit in failing}


def test_an_error_in_the_first_begin_stops_the_run(server: Server, world: World, run: pb.Run) -> None:
    class Unready(Recorder):
        def begin(self, episode: Any) -> None:
            raise RuntimeError("no weights")

    with pytest.raises(AgentStoppedError, match=NEVER) as stopped:
        played(server, run, Unready())
    assert 'raise RuntimeError("no weights")' in stopped.value.details
    assert (world.reasons, FAILURES_IN_A_ROW) == ({}, 3)


@pytest.mark.parametrize("answer", [
    [3, 2, 1, 0], (0, 0, 0, 0), np.array([0, 1, 2, 3]), np.array([0, 1, 2, 3], np.uint8), [np.int64(3)] * 4,
])  # fmt: skip
def test_integers_of_every_kind_are_actions(server: Server, world: World, run: pb.Run, answer: Any) -> None:
    outcome, _ = played(server, run, ActionHandler(answer))
    assert outcome.failures == ()
    assert [world.actions[f"e{i}"][2] for i in range(4)] == [int(action) for action in answer]


def test_an_error_in_begin_gives_up_only_that_episode(server: Server, world: World, run: pb.Run) -> None:
    class Picky(Recorder):
        def begin(self, episode: Any) -> None:
            if episode.episode_id == "e2":
                raise RuntimeError("not this one")
            super().begin(episode)

    agent = Picky()
    outcome, _ = played(server, run, agent, keep_going=True)
    assert world.reasons == {"e2": "begin() raised RuntimeError: not this one"}
    assert sorted(agent.asked) == [pair for pair in EVERYTHING if pair[0] != "e2"]
    assert [failure.episode_ids for failure in outcome.failures] == [("e2",)]
    assert 'raise RuntimeError("not this one")' in outcome.failures[0].details
    assert "arramon_client" not in outcome.failures[0].details


def test_a_failure_during_replay_gives_up_after_the_history(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)

    class Forgetful(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            if any(observation.episode_id == "e0" and observation.step == 1 for observation in observations):
                raise RuntimeError("lost")
            return super().act(observations)

    outcome, _ = played(server, run, Forgetful(), resume=True)
    assert not outcome.actions.get("e0"), "the agent was not shown all of it"
    assert world.reasons["e0"] == "act() raised RuntimeError: lost"
    assert world.actions["e0"] == [0, 1, 2]
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_an_observation_follows_the_contract(server: Server, run: pb.Run) -> None:
    seen: list[Any] = []

    class Looking(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            seen.extend(observations)
            return super().act(observations)

    played(server, run, Looking(), parallel=1)
    first = seen[0]
    assert (first.episode_id, first.turn, first.phase, first.step) == ("e0", 1, "navigation", 0)
    assert (first.instruction, first.phase_step, first.steps_left, first.pose) == ("go 0", 0, 5, None)
    assert first.rgb.tolist() == [[[0, 1, 2], [3, 4, 5], [6, 7, 8]], [[9, 10, 11], [12, 13, 14], [15, 16, 17]]]
    assert first.depth.dtype == np.float32
    assert first.depth.tolist() == [[1.0, np.float32(65.535)]]


def test_a_segmentation_comes_with_its_labels(server: Server, world: World) -> None:
    class Looker(Recorder):
        def begin(self, episode: Episode) -> None:
            self.labels = episode.labels

        def act(self, observations: Sequence[Any]) -> list[int]:
            self.seen = observations[0].segmentation
            return super().act(observations)

    sensors = ["rgb", "segmentation"]
    run = world.create(pb.CreateRunRequest(agent="looker", split="val_seen", language="en", sensors=sensors))
    agent = Looker()
    played(server, run, agent)
    assert agent.labels == (Label("nothing"), Label("mug", "red", "dotted"))
    assert (agent.seen.dtype, agent.seen.tolist()) == (np.uint16, [[1, 0]])


def test_unavailable_shared_memory_falls_back_to_raw_images(server: Server, world: World, run: pb.Run) -> None:
    outcome, notices = played(server, run, Recorder(), encoding=types_pb2.ENCODING_SHARED)
    assert [opening.encoding for opening in world.opens] == [types_pb2.ENCODING_SHARED, types_pb2.ENCODING_RAW]
    assert len({opening.player for opening in world.opens}) == 1
    (notice,) = notices
    assert notice.startswith(
        "images are sent in messages: shared memory is not available: /proc/2147483648/fd/3 cannot"
    )
    assert (outcome.steps, world.actions) == (20, BY_RULE)


def test_an_interrupt_is_not_a_failure_of_the_agent(server: Server, world: World, run: pb.Run) -> None:
    with pytest.raises(KeyboardInterrupt):
        played(server, run, ActionHandler(KeyboardInterrupt()))
    assert world.reasons == {}
