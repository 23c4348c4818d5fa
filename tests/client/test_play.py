"""The play loop against a scripted server: batches, broken streams, history, agents that fail."""

import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import Outcome, Progress, ProtocolError, ServerUnreachableError, Settings, connect, play
from arramon_client.agent import Episode, Label
from arramon_client.connection import Server
from tests.client.fake import Recorder, Servicer, World, serving

EVERYTHING = [(f"e{i}", step) for i in range(4) for step in range(5)]
BY_RULE = {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}


def played(server: Server, run: pb.Run, agent: Any, **settings: Any) -> tuple[Outcome, list[str]]:
    notices: list[str] = []
    chosen = Settings(**{"parallel": 4, **settings})
    return play(server.stub, run, agent, chosen, address=server.address, notify=notices.append), notices


@pytest.mark.parametrize("parallel", [1, 3, 4, 16])
def test_every_step_is_asked_once_and_recorded(server: Server, world: World, run: pb.Run, parallel: int) -> None:
    agent = Recorder()
    outcome, notices = played(server, run, agent, parallel=parallel)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert agent.begun == ["e0", "e1", "e2", "e3"]
    assert (outcome.steps, outcome.failures, outcome.reconnections, notices) == (20, (), 0, [])
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_what_arrives_together_is_one_batch_in_both_directions(server: Server, world: World, run: pb.Run) -> None:
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
def test_a_cut_stream_changes_nothing(server: Server, world: World, run: pb.Run, cut: dict[int, str]) -> None:
    world.cut = cut
    agent = Recorder()
    outcome, notices = played(server, run, agent)
    assert sorted(agent.asked) == EVERYTHING
    assert agent.begun == ["e0", "e1", "e2", "e3"]
    assert world.actions == BY_RULE
    assert outcome.reconnections == len(cut)
    assert len({opening.player for opening in world.opens}) == 1
    assert "UNAVAILABLE: cut" in notices[0]


def test_a_server_that_restarts_at_its_address_is_found_again(world: World, run: pb.Run, tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/s"
    half = threading.Event()

    class Waiting(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            if len(self.asked) >= 8 and not half.is_set():
                half.set()
                time.sleep(0.2)  # The server goes away while the agent thinks.
            return super().act(observations)

    agent = Waiting()
    outcomes: list[Outcome] = []
    first = serving(Servicer(world), address)
    first.__enter__()
    with connect(address) as server:
        player = threading.Thread(target=lambda: outcomes.append(played(server, run, agent)[0]))
        player.start()
        assert half.wait(5)
        first.__exit__(None, None, None)
        with serving(Servicer(world), address):
            player.join(20)
    assert sorted(agent.asked) == EVERYTHING
    assert world.actions == BY_RULE
    assert outcomes[0].reconnections >= 1


def test_a_server_that_stays_away_is_given_up_with_the_run_named(world: World, run: pb.Run) -> None:
    class Away(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            context.__exit__(None, None, None)
            return super().act(observations)

    context = serving(Servicer(world))
    with connect(context.__enter__()) as server, pytest.raises(ServerUnreachableError, match="--resume run-1"):
        played(server, run, Away(), patience=0.3)


def test_an_embedded_server_is_revived_before_another_try(server: Server, world: World, run: pb.Run) -> None:
    world.cut = {3: "after", 8: "before"}
    revived: list[int] = []
    play(server.stub, run, Recorder(), Settings(parallel=4), revive=lambda: revived.append(1))
    assert len(revived) == 2


def half_played(world: World) -> None:
    world.actions = {"e0": [0, 1, 2], "e1": [1]}
    world.players = {"e0": "another", "e1": "another"}


@pytest.mark.parametrize("cut", [{}, {1: "before"}, {2: "after"}, {5: "before", 6: "after"}])
def test_resume_shows_the_history_in_order_and_sends_none_of_it(
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


def test_an_agent_that_acts_otherwise_than_before_is_warned_of_once(server: Server, world: World, run: pb.Run) -> None:
    half_played(world)
    world.actions["e0"] = [3, 3, 3]
    agent = Recorder()
    outcome, notices = played(server, run, agent, resume=True)
    assert [notice for notice in notices if "not deterministic" in notice] == [
        "the agent is not deterministic: at step 0 of episode e0 it took 3 before and takes 0 now; "
        "its state may differ from what it was"
    ]
    assert world.actions["e0"] == [3, 3, 3, 3, 0]
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_an_episode_that_another_player_left_in_mid_play_is_rebuilt(server: Server, world: World, run: pb.Run) -> None:
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


def test_episodes_that_the_server_gave_to_another_are_forgotten(server: Server, world: World, run: pb.Run) -> None:
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


def test_not_your_episode_is_shown_and_the_others_go_on(server: Server, world: World, run: pb.Run) -> None:
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
def test_a_fault_of_the_client_is_an_error(
    server: Server, world: World, run: pb.Run, code: pb.Problem.Code.ValueType
) -> None:
    world.problems = {3: code}
    with pytest.raises(ProtocolError, match=pb.Problem.Code.Name(code)):
        played(server, run, Recorder())


class Answering(Recorder):
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
def test_an_agent_that_answers_nonsense_gives_its_batch_up(
    server: Server, world: World, run: pb.Run, answer: Any, said: str
) -> None:
    outcome, notices = played(server, run, Answering(answer))
    assert set(world.reasons) == {"e0", "e1", "e2", "e3"}
    assert all(said in reason for reason in world.reasons.values())
    assert outcome.failures[0].episode_ids == ("e0", "e1", "e2", "e3")
    assert said in notices[0]
    assert set(world.causes.values()) == {types_pb2.CAUSE_FORFEITED}


@pytest.mark.parametrize("answer", [
    [3, 2, 1, 0], (0, 0, 0, 0), np.array([0, 1, 2, 3]), np.array([0, 1, 2, 3], np.uint8), [np.int64(3)] * 4,
])  # fmt: skip
def test_integers_of_every_kind_are_actions(server: Server, world: World, run: pb.Run, answer: Any) -> None:
    outcome, _ = played(server, run, Answering(answer))
    assert outcome.failures == ()
    assert [world.actions[f"e{i}"][2] for i in range(4)] == [int(action) for action in answer]


def test_an_agent_that_raises_in_begin_gives_that_episode_up_alone(server: Server, world: World, run: pb.Run) -> None:
    class Picky(Recorder):
        def begin(self, episode: Any) -> None:
            if episode.episode_id == "e2":
                raise RuntimeError("not this one")
            super().begin(episode)

    agent = Picky()
    outcome, _ = played(server, run, agent)
    assert world.reasons == {"e2": "begin() raised RuntimeError: not this one"}
    assert sorted(agent.asked) == [pair for pair in EVERYTHING if pair[0] != "e2"]
    assert [failure.episode_ids for failure in outcome.failures] == [("e2",)]
    assert 'raise RuntimeError("not this one")' in outcome.failures[0].details
    assert "arramon_client" not in outcome.failures[0].details


def test_an_agent_that_fails_while_its_history_is_shown_gives_up_later(
    server: Server, world: World, run: pb.Run
) -> None:
    half_played(world)

    class Forgetful(Recorder):
        def act(self, observations: Sequence[Any]) -> list[int]:
            if any(observation.episode_id == "e0" and observation.step == 1 for observation in observations):
                raise RuntimeError("lost")
            return super().act(observations)

    outcome, _ = played(server, run, Forgetful(), resume=True)
    assert world.reasons["e0"] == "act() raised RuntimeError: lost"
    assert world.actions["e0"] == [0, 1, 2]
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_an_observation_is_what_the_contract_says(server: Server, run: pb.Run) -> None:
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


def test_memory_that_is_not_to_be_had_is_done_without(server: Server, world: World, run: pb.Run) -> None:
    outcome, notices = played(server, run, Recorder(), encoding=types_pb2.ENCODING_SHARED)
    assert [opening.encoding for opening in world.opens] == [types_pb2.ENCODING_SHARED, types_pb2.ENCODING_RAW]
    assert len({opening.player for opening in world.opens}) == 1
    assert [notice.partition(":")[0] for notice in notices] == ["images travel in messages"]
    assert (outcome.steps, world.actions) == (20, BY_RULE)


def test_an_interrupt_is_not_taken_for_a_failure_of_the_agent(server: Server, world: World, run: pb.Run) -> None:
    with pytest.raises(KeyboardInterrupt):
        played(server, run, Answering(KeyboardInterrupt()))
    assert world.reasons == {}
