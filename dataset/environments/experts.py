"""Experts that return the right action in any state: along the reference path, or along the shortest path."""

import math
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from itertools import pairwise
from typing import Protocol

from arramon_client import agent as client
from arramon_client.plugin.loader import load_agent
from arramon_client.world import COLUMNS, HEADINGS, ROWS, TURN, Action, turn_between
from arramon_dataset.environments.number_pool import expert_numbers
from arramon_server.api.messages import oracle_message
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.geometry import Pose
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import CollisionCheck, Limits, Phase, State, reachable
from arramon_server.sim.scene import Scene
from arramon_server.sim.view import visible_pose

SHORTEST_PATH = "agents.shortest_path"
"""The agent that plans shortest paths, loaded by name because the data set package does not import agents."""

GRAIN = 0.02
"""Side of the squares in which two positions count as equal, in units: far above rounding errors, far below the
distance of different walks."""

OFFSET = 0.00714
"""Offset of these squares, so that positions with few decimals do not lie on their edges."""

LONGEST = 1000
"""Maximum number of actions of a planned path; a longer one is discarded."""

QUARTER = HEADINGS // 4
"""Number of turns in a quarter turn."""

Key = tuple[int, int]
PhaseKey = tuple[int, Phase]


class Expert(Protocol):
    """Advises actions in one episode, given its ground truth."""

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the current state of the episode."""


class ShortestExpert:
    """Advises the shortest path to each target, and to a cell from which it can be placed.

    In the city the path is planned by `agents.shortest_path`, with some distance from walls and few turns. A plan takes
    milliseconds and is kept as long as it is followed. Where that agent finds no path, because it is closer to a wall
    than plans may come, the expert first goes back the way the agent came.

    Args:
        episode: the episode to play.
        scene: of its section.
        way_back: returns the action that leads back the way the agent came; None if there is none.
    """

    def __init__(self, episode: Episode, scene: Scene, way_back: Callable[[EpisodeSession], Action | None]) -> None:
        self._way_back = way_back
        self._agent = _shortest_path_agent(threading.get_ident())
        # All experts of the thread share the agent, so each gets an episode id of its own, even in the same episode.
        number = expert_numbers().take(self)
        self._episode = client.Episode(str(number), "", "", oracle=oracle_message(episode, scene))
        self._step, self._advised = -1, Action.FORWARD
        self._rooms = [
            first_action_to_place(RoomCell(turn.target_cell.column, turn.target_cell.row)) for turn in episode.turns
        ]

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the current state of the episode."""
        state = session.state
        if state.phase is Phase.ASSEMBLY:
            return self._rooms[state.turn - 1][state.square, round(state.room_heading / TURN) % HEADINGS]
        followed = state.step == self._step + 1 and session.actions[-1:] == [self._advised]
        if state.step == self._step:
            return self._advised
        if not followed:
            self._agent.begin(self._episode)
        pose = visible_pose(state)
        observation = client.Observation(
            episode_id=self._episode.episode_id,
            turn=state.turn,
            phase=state.phase.value,
            step=state.step,
            instruction="",
            phase_step=state.phase_step,
            steps_left=session.steps_left(state),
            pose=(pose.x, pose.z, pose.heading),
        )
        (action,) = client.actions_of(self._agent.act([observation]))
        advised = Action(action)
        if advised is Action.INTERACT and reachable(pose, session.episode.turns[state.turn - 1].street) != 0:
            back = self._way_back(session)
            advised = Action.INTERACT if back is None else back
            self._step = -1  # Replan after this action.
        else:
            self._step = state.step
        self._advised = advised
        return advised


class ReferenceExpert:
    """Advises the reference path: back to the ground truth's path the way the agent came, then along it.

    On the path the advice is the ground truth. Each step forward that it advises brings the agent nearer to the path,
    or further along it, so that it never oscillates. If turn 2 begins off the path because turn 1 ended elsewhere, the
    shortest path from there is planned once and added to the reference path.

    Args:
        episode: the episode to play.
        scene: of its section.
        ground: of its section.
    """

    def __init__(self, episode: Episode, scene: Scene, ground: CollisionCheck) -> None:
        self._episode, self._scene, self._ground = episode, scene, ground
        self._references = dict(_references(episode, ground))
        self._shortest: ShortestExpert | None = None

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the current state of the episode."""
        found = self.next_action(session)
        if found is not None:
            return found
        if self._shortest is None:
            self._shortest = ShortestExpert(self._episode, self._scene, lambda _: None)
        key = session.state.turn, session.state.phase
        link = self._planned_link(session.state)
        if link is None:
            return self._shortest.action(session)
        self._references[key].prepend(link)
        found = self.next_action(session)
        assert found is not None
        return found

    def _planned_link(self, state: State) -> "_Reference | None":
        """Return the shortest path from a state in the city to the reference path or the target; None without one."""
        assert self._shortest is not None
        path = self._references[state.turn, state.phase]
        trial = EpisodeSession(self._episode, self._ground, Limits(steps_per_phase=2 * LONGEST))
        trial.state = state
        poses = []
        for _ in range(LONGEST):
            pose = visible_pose(trial.state)
            poses.append(pose)
            if _key(pose.x, pose.z) in path.next:
                return _Reference(poses)
            action = self._shortest.action(trial)
            if action is Action.INTERACT:
                found = reachable(trial.state.pose, trial.episode.turns[state.turn - 1].street) == 0
                return _Reference(poses) if found else None
            trial.apply(action)
        return None

    def next_action(self, session: EpisodeSession) -> Action | None:
        """Return the action back to the path or along it; None if the agent's walk does not link it to the path."""
        state = session.state
        pose = visible_pose(state)
        reference = self._references[state.turn, state.phase]
        here = _key(pose.x, pose.z)
        if here in reference.next:
            following = reference.next[here]
            if following is None:
                turn = _turn(pose.heading, reference.headings[here])
                return Action.INTERACT if turn is None else turn
            return _towards(pose, following)
        links = _ROOM if state.phase is Phase.ASSEMBLY else _links(session.record().turns[state.turn - 1].path)
        back = _first_step(here, links, reference.next)
        return None if back is None else _towards(pose, back)


@cache
def first_action_to_place(target: RoomCell) -> Mapping[tuple[RoomCell, int], Action]:
    """Return the first action of the shortest way to place an object, by cell and heading index (30 degrees each).

    Args:
        target: the cell in which to place it. Objects in the room do not block the agent.
    """
    squares = [RoomCell(column, row) for column in range(COLUMNS) for row in range(ROWS)]
    before: dict[tuple[RoomCell, int], list[tuple[RoomCell, int, Action]]] = {}
    advice: dict[tuple[RoomCell, int], Action] = {}
    for square in squares:
        for heading in range(HEADINGS):
            for action, turned in ((Action.RIGHT, 1), (Action.LEFT, -1)):
                after = square, (heading + turned) % HEADINGS
                before.setdefault(after, []).append((square, heading, action))
            if heading % QUARTER == 0:
                ahead = square.ahead(heading * TURN)
                if ahead == target:
                    advice[square, heading] = Action.INTERACT
                elif ahead.is_inside():
                    before.setdefault((ahead, heading), []).append((square, heading, Action.FORWARD))
    queue = deque(advice)
    while queue:
        for square, heading, action in before[queue.popleft()]:
            if (square, heading) not in advice:
                advice[square, heading] = action
                queue.append((square, heading))
    return advice


def make_expert(name: str, episode: Episode, scene: Scene, ground: CollisionCheck) -> Expert:
    """Return an episode's expert by name: "reference" or "shortest"."""
    reference = ReferenceExpert(episode, scene, ground)
    return ShortestExpert(episode, scene, reference.next_action) if name == "shortest" else reference


class _Reference:
    """The reference path through one phase.

    Args:
        poses: in order, as `visible_pose` returns them.

    Attributes:
        next: the next position (x, z) for each position, None for the last. If the path revisits a position, its last
            visit counts.
        headings: the final heading for each last position, in degrees.
    """

    def __init__(self, poses: Sequence[Pose]) -> None:
        self.headings = {_key(poses[-1].x, poses[-1].z): poses[-1].heading}
        self.next: dict[Key, tuple[float, float] | None] = {}
        for pose, following in zip(poses, (*poses[1:], None), strict=True):
            if following is None:
                self.next[_key(pose.x, pose.z)] = None
            elif _key(following.x, following.z) != _key(pose.x, pose.z):
                self.next[_key(pose.x, pose.z)] = following.x, following.z

    def prepend(self, earlier: "_Reference") -> None:
        """Add a path that leads to this path or to its target; this path takes precedence at shared positions."""
        self.next, self.headings = {**earlier.next, **self.next}, {**earlier.headings, **self.headings}


def _references(episode: Episode, ground: CollisionCheck) -> Iterator[tuple[PhaseKey, _Reference]]:
    """Yield the reference path of each turn and phase, by playing the ground truth."""
    session = EpisodeSession(episode, ground, Limits(steps_per_phase=1_000_000))
    for number, turn in enumerate(episode.turns, start=1):
        for phase, actions in ((Phase.NAVIGATION, turn.actions), (Phase.ASSEMBLY, turn.room_actions)):
            yield (number, phase), _Reference([visible_pose(state) for state, _ in session.replay(actions)])


def _key(x: float, z: float) -> Key:
    return int((x - OFFSET) // GRAIN), int((z - OFFSET) // GRAIN)


def _towards(pose: Pose, place: tuple[float, float]) -> Action:
    """Return the action that turns towards a place one step away, or moves there."""
    heading = math.degrees(math.atan2(place[0] - pose.x, place[1] - pose.z))
    turn = _turn(pose.heading, heading)
    return Action.FORWARD if turn is None else turn


def _turn(heading: float, wanted: float) -> Action | None:
    """Return the turn towards a heading, the shorter way; None if the heading is right."""
    turns = round(turn_between(heading, wanted) / TURN)
    if turns == 0:
        return None
    return Action.RIGHT if turns > 0 or turns == -6 else Action.LEFT


Links = Mapping[Key, Sequence[tuple[float, float]]]
"""The positions (x, z) one step away from each position, in a fixed order."""


def _links(path: Sequence[tuple[float, float]]) -> Links:
    """Return the links between successive positions of a walk, in both directions."""
    links: dict[Key, list[tuple[float, float]]] = {}
    for one, other in pairwise(path):
        links.setdefault(_key(*one), []).append(other)
        links.setdefault(_key(*other), []).append(one)
    return links


def _first_step(start: Key, links: Links, goals: Mapping[Key, object]) -> tuple[float, float] | None:
    """Return the first position of the path with the fewest steps to any goal; None if there is no path."""
    queue: deque[tuple[Key, tuple[float, float] | None]] = deque([(start, None)])
    seen = {start}
    while queue:
        here, first = queue.popleft()
        if first is not None and here in goals:
            return first
        for place in links.get(here, ()):
            key = _key(*place)
            if key not in seen:
                seen.add(key)
                queue.append((key, first or place))
    return None


_ROOM: Links = {
    _key(column, row): [
        (float(ahead.column), float(ahead.row))
        for ahead in (RoomCell(column, row).ahead(heading) for heading in (0.0, 90.0, 180.0, 270.0))
        if ahead.is_inside()
    ]
    for column in range(COLUMNS)
    for row in range(ROWS)
}


@lru_cache(4)
def _shortest_path_agent(thread: int) -> client.Agent:  # noqa: ARG001 - each thread has its own
    return load_agent(SHORTEST_PATH)
