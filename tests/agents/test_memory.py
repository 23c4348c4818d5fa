"""Memory use over up to 1,000 episodes: agents and client discard the state of ended episodes."""

import gc
import sys
from collections import deque
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_agents.mapping.ground_map import GroundMap
from arramon_client import Agent, load_agent
from arramon_client.plugin.failures import FailureCounter
from arramon_client.session import Session
from arramon_server.sim.labels import LABELS

FIRST, FEW, EPISODES, PARALLEL = 16, 40, 1000, 8
SIZE = 32

PHASES = (types_pb2.PHASE_NAVIGATION, types_pb2.PHASE_ASSEMBLY)
"""The phase of each step of an episode."""

INSTRUCTIONS = {
    types_pb2.PHASE_NAVIGATION: "Go on to the striped red mug.",
    types_pb2.PHASE_ASSEMBLY: "Put it two steps ahead.",
}


def image(array: "np.ndarray[Any, Any]") -> types_pb2.Image:
    return types_pb2.Image(height=SIZE, width=SIZE, encoding=types_pb2.ENCODING_RAW, data=array.tobytes())


ROWS = np.arange(SIZE)[:, None] + np.zeros((1, SIZE), int)
RGB = image(np.repeat(ROWS[..., None], 3, -1).astype(np.uint8))
DEPTH = image(np.where(ROWS > SIZE // 2, 17_000 // (ROWS - SIZE // 2 + 1e-9), 0).clip(0, 65535).astype("<u2"))
SEGMENTATION = image(np.where(ROWS > SIZE // 2, [each.kind for each in LABELS].index("road"), 0).astype("<u2"))

ORACLE = pb.Oracle(agent_radius=0.25, targets=[
    pb.Target(position=types_pb2.Position(x=0.0, z=3.0), cell=types_pb2.Cell(column=2, row=2)),
    pb.Target(position=types_pb2.Position(x=3.0, z=3.0), cell=types_pb2.Cell(column=2, row=2)),
])  # fmt: skip


def started(episode_id: str) -> pb.Event:
    start = pb.EpisodeStarted(episode_id=episode_id, language="en", split="val_seen", oracle=ORACLE)
    return pb.Event(episode_started=start)


def seen(episode_id: str, step: int) -> pb.Event:
    phase = PHASES[step]
    pose = types_pb2.Pose(x=2.0) if phase == types_pb2.PHASE_ASSEMBLY else types_pb2.Pose()
    return pb.Event(observation=pb.Observation(
        episode_id=episode_id, step=step, turn=1, phase=phase, instruction=INSTRUCTIONS[phase], phase_step=step,
        steps_left=len(PHASES) - step, rgb=RGB, depth=DEPTH, segmentation=SEGMENTATION, pose=pose,
    ))  # fmt: skip


def ended(episode_id: str) -> pb.Event:
    return pb.Event(episode_ended=pb.EpisodeEnded(episode_id=episode_id, cause=types_pb2.CAUSE_TIME_LIMIT))


def session_of(agent: Agent) -> Session:
    run = pb.Run(run_id="1f" * 16, episodes=FIRST + EPISODES, split="val_seen", language="en")
    session = Session(run, agent, lambda _: None, FailureCounter(keep_going=False))
    session.start_stream(history=False)
    labels = [pb.Label(kind=each.kind, colour=each.colour, look=each.look) for each in LABELS]
    session.take(pb.Event(opened=pb.Opened(run=run, labels=labels)))
    return session


def play(session: Session, first: int, count: int) -> None:
    """Play episodes to their ends, in groups: the messages are those of a server, without a network."""
    for start in range(first, first + count, PARALLEL):
        ids = [f"e{number}" for number in range(start, min(start + PARALLEL, first + count))]
        for episode_id in ids:
            session.take(started(episode_id))
        for step in range(len(PHASES)):
            for episode_id in ids:
                session.take(seen(episode_id, step))
            assert len(session.answer()) == len(ids)
        for episode_id in ids:
            session.take(ended(episode_id))
    assert session.failures == []


def objects_in(root: object) -> int:
    """Return the number of objects that can be reached from one, other than through modules and classes."""
    known = {id(root), *(id(vars(module)) for module in list(sys.modules.values()))}
    waiting = deque([root])
    while waiting:
        each = waiting.popleft()
        for other in gc.get_referents(each):
            kind = type(other)  # Not by isinstance, which asks the object itself: some of torch's warn at that.
            if id(other) in known or issubclass(kind, ModuleType | type | BuiltinFunctionType):
                continue
            known.add(id(other))
            if kind is FunctionType:  # Its closure counts, but not its module.
                waiting.extend(other.__closure__ or ())
            else:
                waiting.append(other)
    return len(known)


def growth(agent: Agent, episodes: int) -> tuple[int, int]:
    """Return by how many objects an agent grows over some episodes, and by how many the rest of its session."""
    session = session_of(agent)
    play(session, 0, FIRST)  # Fills caches of texts and frames.
    before = objects_in(agent), objects_in(session)
    play(session, FIRST, episodes)
    assert len(session.actions) == FIRST + episodes
    session.actions.clear()  # What was sent, which the run's receipt is compared with.
    after = objects_in(agent), objects_in(session)
    of_agent = after[0] - before[0]
    return of_agent, after[1] - before[1] - of_agent


QUICK: list[tuple[str, dict[str, object]]] = [
    ("agents.follower", {}),
    ("agents.shortest_path", {}),
    ("examples.my_agent", {}),
]

LEARNED: list[tuple[str, dict[str, object]]] = [
    ("agents.seeing_follower", {}),
    ("agents.vl", {}),
    ("agents.vl_map", {}),
    ("agents.vl_map", {"sensor": "segmentation"}),
    ("agents.vl_grounded", {}),
    ("agents.vl_grounded", {"sensor": "segmentation"}),
]
"""Agents that compute more for each episode: few episodes show as well whether each of them leaves an object."""


@pytest.mark.parametrize(("name", "arguments", "episodes"), [
    *((*each, EPISODES) for each in QUICK),
    *((*each, FEW) for each in LEARNED),
])  # fmt: skip
def test_an_agent_does_not_grow_with_the_number_of_episodes(
    name: str, arguments: dict[str, object], episodes: int
) -> None:
    of_agent, of_session = growth(load_agent(name, arguments), episodes)
    assert of_agent < episodes // 4
    assert of_session <= 0


@pytest.mark.parametrize(("name", "arguments"), [*QUICK, *LEARNED])
def test_without_end_an_agent_grows_by_every_episode(name: str, arguments: dict[str, object]) -> None:
    """The test above fails without `end`."""
    agent = load_agent(name, arguments)
    agent.end = None  # type: ignore[attr-defined]
    of_agent, of_session = growth(agent, FEW)
    assert of_agent >= FEW
    assert of_session <= 0


def test_a_follower_has_a_map_for_open_episodes_alone() -> None:
    before = maps()
    session = session_of(load_agent("agents.follower"))
    play(session, 0, FIRST)
    for episode_id in ("a", "b"):
        session.take(started(episode_id))
    assert maps() == before + 2


def maps() -> int:
    gc.collect()
    return sum(type(each) is GroundMap for each in gc.get_objects())
