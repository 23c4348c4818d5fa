"""The shortest-path agent in a toy city, checked by an independent simulation."""

import math
from dataclasses import replace

import pytest

from arramon.v1.evaluation_pb2 import Obstacle, Oracle, Target
from arramon.v1.types_pb2 import Cell, Position
from arramon_agents.shortest_path import Agent
from arramon_agents.shortest_path.clearance_map import ClearanceMap
from arramon_client import Action, Episode, Observation
from tests.work import calls

RADIUS = 0.25

MOST_CALLS = 1_000_000
"""For a whole way with all its plans: about a second's work, twice what the longest way of these takes."""

BLOCKS = [  # Two blocks with a gap of 2 between them, a wall behind, and a post in the gap's mouth.
    Obstacle(x=-6, z=6, half_width=5, half_length=3, heading=0),
    Obstacle(x=6, z=6, half_width=5, half_length=3, heading=0),
    Obstacle(x=0, z=16, half_width=14, half_length=1, heading=10),
    Obstacle(x=0.4, z=2.5, half_width=0.3, half_length=0.3, heading=45),
]


def oracle(target: tuple[float, float], obstacles: list[Obstacle]) -> Oracle:
    cell = Target(position=Position(x=target[0], y=0.1, z=target[1]), cell=Cell(column=3, level=1, row=2))
    return Oracle(agent_radius=RADIUS, obstacles=obstacles, targets=[cell, cell])


def is_free(x: float, z: float, obstacles: list[Obstacle]) -> bool:
    """Whether a disc at a place touches nothing, by the distance to each rectangle."""
    for o in obstacles:
        angle = math.radians(o.heading)
        dx, dz = x - o.x, z - o.z
        across = abs(dx * math.cos(angle) - dz * math.sin(angle)) - o.half_width
        along = abs(dx * math.sin(angle) + dz * math.cos(angle)) - o.half_length
        if math.hypot(max(across, 0), max(along, 0)) < RADIUS:
            return False
    return True


class Street:
    """Simulates navigation: a step that would touch something does not move the agent."""

    def __init__(self, pose: tuple[float, float, float], obstacles: list[Obstacle]) -> None:
        self.pose, self.obstacles, self.steps, self.bumps = pose, obstacles, 0, 0
        self.path = [pose[:2]]

    def observation(self) -> Observation:
        return Observation("e", 1, "navigation", self.steps, "go", self.steps, 150 - self.steps, pose=self.pose)

    def move(self, action: Action) -> None:
        x, z, heading = self.pose
        self.steps += 1
        if action == Action.FORWARD:
            angle = math.radians(heading)
            way = [(x + i / 50 * math.sin(angle), z + i / 50 * math.cos(angle)) for i in range(51)]
            if all(is_free(*place, self.obstacles) for place in way):
                self.pose = (*way[-1], heading)
                self.path.append(way[-1])
            else:
                self.bumps += 1
        else:
            self.pose = (x, z, (heading + (30 if action == Action.RIGHT else -30)) % 360)

    def play(self, agent: Agent, target: tuple[float, float], known: list[Obstacle] | None = None) -> bool:
        """Plays until the agent interacts; whether the target is then in the pick-up box."""
        agent.begin(Episode("e", "en", "toy", oracle(target, self.obstacles if known is None else known)))
        while self.steps < 150:
            (action,) = agent.act([self.observation()])
            if action == Action.INTERACT:
                x, z, heading = self.pose
                angle = math.radians(heading)
                dx, dz = target[0] - x, target[1] - z
                right = dx * math.cos(angle) - dz * math.sin(angle)
                ahead = dx * math.sin(angle) + dz * math.cos(angle)
                return abs(right) <= 0.5 and 0 < ahead <= 3
            self.move(action)
        return False


@pytest.mark.parametrize(("start", "target", "most"), [
    ((0.0, 0.0, 0.0), (0.0, 0.5), 12),  # Too near to be picked up where it stands: it has to step away.
    ((0.0, -5.0, 28.8), (0.0, 1.0), 12),
    ((0.0, -1.0, 28.8), (0.0, 12.0), 25),  # Through the gap, past the post.
    ((-8.0, 0.0, 298.8), (-8.0, 11.5), 45),
    ((9.0, 0.0, 88.8), (-9.0, 11.0), 45),
    ((-12.5, 12.0, 178.8), (12.5, 0.0), 50),
])  # fmt: skip
def test_the_target_is_reached_without_collisions(
    start: tuple[float, float, float], target: tuple[float, float], most: int
) -> None:
    street = Street(start, BLOCKS)
    reached = []
    work = calls(lambda: reached.append(street.play(Agent(), target)))
    assert reached == [True]
    assert work < MOST_CALLS
    assert street.bumps == 0
    assert street.steps <= most


def test_on_open_ground_the_path_is_straight() -> None:
    street = Street((0.0, 0.0, 28.8), [])
    assert street.play(Agent(), (14.0, 20.0))
    line = math.atan2(14.0, 20.0)
    away = [abs(x * math.cos(line) - z * math.sin(line)) for x, z in street.path]
    assert max(away) < 0.6
    assert sum(math.dist(a, b) for a, b in zip(street.path, street.path[1:], strict=False)) < 1.05 * math.hypot(14, 20)


def test_unknown_obstacles_are_avoided() -> None:
    street = Street((0.0, 0.0, 0.0), [*BLOCKS, Obstacle(x=-0.3, z=4.0, half_width=0.2, half_length=0.2)])
    assert street.play(Agent(), (0.0, 12.0), known=BLOCKS)
    assert 1 <= street.bumps <= 6


def test_the_same_observations_give_the_same_actions() -> None:
    one, other = Street((0.0, -1.0, 28.8), BLOCKS), Street((0.0, -1.0, 28.8), BLOCKS)
    agent = Agent()
    one.play(agent, (0.0, 12.0))
    other.play(agent, (0.0, 12.0))
    assert one.path == other.path


def test_agent_goes_to_each_turns_own_target_and_cell() -> None:
    agent = Agent()
    agent.begin(Episode("e", "en", "toy", oracle((0.0, 1.5), [])))
    city = Observation("e", 1, "navigation", 0, "", 0, 150, pose=(0.0, 0.0, 0.0))
    assert agent.act([city]) == [Action.INTERACT]
    room = replace(city, phase="assembly", pose=(2.0, 0.0, 0.0))
    assert agent.act([room]) == [Action.FORWARD]
    assert agent.act([replace(room, pose=(2.0, 1.0, 0.0))]) == [Action.FORWARD]
    # Something stood there: the agent did not move, and finds another way.
    assert agent.act([replace(room, pose=(2.0, 1.0, 0.0))])[0] in (Action.LEFT, Action.RIGHT)
    assert agent.act([replace(city, turn=2, pose=(0.0, 0.0, 0.0))]) == [Action.INTERACT]


def test_in_a_blocked_room_the_path_crosses_objects() -> None:
    everything = oracle((0.0, 1.5), [])
    everything.targets[0].occupied.extend(Cell(column=c, level=1, row=r) for c, r in ((1, 0), (2, 1), (3, 0)))
    agent = Agent()
    agent.begin(Episode("e", "en", "toy", everything))
    room = Observation("e", 1, "assembly", 0, "", 0, 150, pose=(2.0, 0.0, 0.0))
    actions, poses = [], ((2.0, 0.0), (2.0, 1.0), (2.0, 2.0))
    for x, z in poses:
        actions += agent.act([replace(room, pose=(x, z, 0.0))])
    assert actions == [Action.FORWARD, Action.FORWARD, Action.RIGHT]


@pytest.mark.parametrize("missing", ["oracle", "pose"])
def test_missing_sensors_are_named(missing: str) -> None:
    agent = Agent()
    episode = Episode("e", "en", "toy", None if missing == "oracle" else oracle((0.0, 9.0), []))
    with pytest.raises(ValueError, match=f"requires the sensor {missing}"):  # noqa: PT012 - either of the two may raise
        agent.begin(episode)
        agent.act([Observation("e", 1, "navigation", 0, "", 0, 150)])


@pytest.mark.parametrize(("start", "end", "free"), [
    ((0.0, 0.0), (0.0, 1.0), True),
    ((0.0, 1.83), (1.0, 1.83), False),  # Past the post's corner, which is at z = 2.076: 0.246 from it.
    ((0.0, 1.81), (1.0, 1.81), True),  # 0.266 from it.
    ((-0.7, 4.0), (-0.7, 8.0), True),  # 0.3 from the block.
    ((-0.76, 4.0), (-0.76, 8.0), False),  # 0.24 from the block.
    ((-6.0, 0.0), (-6.0, 12.0), False),
    ((-6.0, 5.0), (-6.0, 6.0), False),
    ((200.0, 0.0), (201.0, 0.0), False),  # Off the map.
])  # fmt: skip
def test_ground_is_free_only_beyond_the_agents_radius(
    start: tuple[float, float], end: tuple[float, float], free: bool
) -> None:
    assert ClearanceMap(BLOCKS, RADIUS).is_free(start, end) is free
