"""Experts: the right action in any state of an episode, back to the reference path and on, or the shortest way."""

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
from arramon_dataset.environments.slots import expert_slots
from arramon_server.api.messages import oracle_message
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.geometry import Pose
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import CollisionCheck, Limits, Phase, State, reachable
from arramon_server.sim.scene import Scene
from arramon_server.sim.view import visible_pose

SHORTEST_PATH = "agents.shortest_path"
"""The agent that plans the shortest way, loaded by name because the server does not import agents."""

GRAIN = 0.02
"""Side of the squares in which two positions count as the same, in units: far more than rounding, far less than what
two walks differ by."""

OFFSET = 0.00714
"""Offset of these squares, so that positions of few decimals do not lie on their edges."""

LONGEST = 1000
"""Actions from which on a planned way is given up: it leads nowhere."""

QUARTER = HEADINGS // 4
"""Turns of a quarter."""

Key = tuple[int, int]
PhaseKey = tuple[int, Phase]


class Expert(Protocol):
    """Knows the ground truth of one episode."""

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the present state of the episode."""


class ShortestExpert:
    """The shortest way to each target, and to a cell from which it can be placed.

    In the city a plan takes milliseconds and is kept as long as it is followed. It is the shortest one by the agent
    `agents.shortest_path`: with a little distance from walls, and with few turns. Where that agent finds no way, as it
    stands nearer to a wall than its plans may come, it goes back the way it came first.

    Args:
        episode: that is played.
        scene: of its section.
        way_back: returns the action that leads back the way that the agent came; None if there is none.
    """

    def __init__(self, episode: Episode, scene: Scene, way_back: Callable[[EpisodeSession], Action | None]) -> None:
        self._way_back = way_back
        self._agent = _shortest_path_agent(threading.get_ident())
        # The agent serves all experts of the thread, which may play the same episode: its memory of each is apart.
        slot = expert_slots().take(self)
        self._episode = client.Episode(str(slot), "", "", oracle=oracle_message(episode, scene))
        self._step, self._advised = -1, Action.FORWARD
        self._rooms = [room_advice(RoomCell(turn.target_cell.column, turn.target_cell.row)) for turn in episode.turns]

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the present state of the episode."""
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
        (action,) = self._agent.act([observation])
        advised = Action(action)
        if advised is Action.INTERACT and reachable(pose, session.episode.turns[state.turn - 1].street) != 0:
            back = self._way_back(session)
            advised = Action.INTERACT if back is None else back
            self._step = -1  # Planned anew from where this leads.
        else:
            self._step = state.step
        self._advised = advised
        return advised


class ReferenceExpert:
    """The way that the instruction tells: back to the ground truth's path, by the way the agent came, and on along it.

    In a state on the path it is the ground truth. Each step forward that it advises brings the agent nearer to the
    path, or further along it, so that it never oscillates. Where turn 2 begins off the path, as turn 1 ended elsewhere,
    the shortest way from there is planned once, and is from then on a part of the path.

    Args:
        episode: that is played.
        scene: of its section.
        ground: of its section.
    """

    def __init__(self, episode: Episode, scene: Scene, ground: CollisionCheck) -> None:
        self._episode, self._scene, self._ground = episode, scene, ground
        self._references = dict(_references(episode, ground))
        self._shortest: ShortestExpert | None = None

    def action(self, session: EpisodeSession) -> Action:
        """Return the right action in the present state of the episode."""
        found = self.way(session)
        if found is not None:
            return found
        if self._shortest is None:
            self._shortest = ShortestExpert(self._episode, self._scene, lambda _: None)
        key = session.state.turn, session.state.phase
        led = self._led(session.state)
        if led is None:
            return self._shortest.action(session)
        self._references[key].begin_with(led)
        found = self.way(session)
        assert found is not None
        return found

    def _led(self, state: State) -> "_Reference | None":
        """Return the shortest way from a state in the city to the target or to the path; None if there is none."""
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

    def way(self, session: EpisodeSession) -> Action | None:
        """Return the action back to the path or on along it; None where no way of the agent links it to the path."""
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
def room_advice(target: RoomCell) -> Mapping[tuple[RoomCell, int], Action]:
    """Return the first action of the shortest way to place an object, by cell and heading in turns of 30 degrees.

    Args:
        target: the cell in which it is to be placed. Objects stop nobody in the room.
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


def expert_of(name: str, episode: Episode, scene: Scene, ground: CollisionCheck) -> Expert:
    """Return the expert of an episode by name: "reference" or "shortest"."""
    reference = ReferenceExpert(episode, scene, ground)
    return ShortestExpert(episode, scene, reference.way) if name == "shortest" else reference


class _Reference:
    """A path through one phase.

    Args:
        poses: in order, in the coordinates of `visible_pose`.

    Attributes:
        next: by position the next one, (x, z); None at the last. Where the path comes back to a position, what follows
            the last visit counts.
        headings: by last position the heading with which the phase is ended there, in degrees.
    """

    def __init__(self, poses: Sequence[Pose]) -> None:
        self.headings = {_key(poses[-1].x, poses[-1].z): poses[-1].heading}
        self.next: dict[Key, tuple[float, float] | None] = {}
        for pose, following in zip(poses, (*poses[1:], None), strict=True):
            if following is None:
                self.next[_key(pose.x, pose.z)] = None
            elif _key(following.x, following.z) != _key(pose.x, pose.z):
                self.next[_key(pose.x, pose.z)] = following.x, following.z

    def begin_with(self, way: "_Reference") -> None:
        """Add a way that leads to this path or to its target; where both have a position, the path counts."""
        self.next, self.headings = {**way.next, **self.next}, {**way.headings, **self.headings}


def _references(episode: Episode, ground: CollisionCheck) -> Iterator[tuple[PhaseKey, _Reference]]:
    """Yield turn and phase with their reference, by playing the ground truth."""
    session = EpisodeSession(episode, ground, Limits(steps_per_phase=1_000_000))
    for number, turn in enumerate(episode.turns, start=1):
        for phase, actions in ((Phase.NAVIGATION, turn.actions), (Phase.ASSEMBLY, turn.room_actions)):
            yield (number, phase), _Reference([visible_pose(state) for state, _ in session.replay(actions)])


def _key(x: float, z: float) -> Key:
    return int((x - OFFSET) // GRAIN), int((z - OFFSET) // GRAIN)


def _towards(pose: Pose, place: tuple[float, float]) -> Action:
    """Return the action that turns to a place one step away, or goes there."""
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
"""By position those that are one step away, (x, z), in a fixed order."""


def _links(path: Sequence[tuple[float, float]]) -> Links:
    """Return the positions that a walk linked, in both directions."""
    links: dict[Key, list[tuple[float, float]]] = {}
    for one, other in pairwise(path):
        links.setdefault(_key(*one), []).append(other)
        links.setdefault(_key(*other), []).append(one)
    return links


def _first_step(start: Key, links: Links, goals: Mapping[Key, object]) -> tuple[float, float] | None:
    """Return the first position of the way with the fewest steps to one of the goals; None if there is none."""
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
