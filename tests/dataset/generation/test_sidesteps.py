"""Random sidesteps: clearance, offset, and the unchanged course of the path."""

import math

import numpy as np

from arramon_client.world import Action
from arramon_dataset.generation.clearance_raster import ClearanceRaster
from arramon_dataset.generation.navigation_tasks import follow_actions
from arramon_dataset.generation.path_planner import REACH_FROM, REACH_TO
from arramon_dataset.generation.sidesteps import MAX_OFFSET, with_sidesteps
from arramon_dataset.layout.solids import Solids
from arramon_dataset.randomness import seeded
from arramon_server.sim.geometry import Pose
from arramon_server.sim.section import Building, Section
from tests.dataset.generation.small_section import CROSSING

START, TARGET = Pose(0.0, -11.0, 0.0), (11.5, 0.0)
WAY = [*[Action.FORWARD] * 11, *[Action.RIGHT] * 3, *[Action.FORWARD] * 10]
TURNS = {Action.LEFT: -1, Action.RIGHT: 1}


def walks(ground: ClearanceRaster, way: list[Action], start: Pose, target: tuple[float, float]) -> list[list[Action]]:
    return [with_sidesteps(ground, start, way, target, seeded("walk", number)) for number in range(40)]


def test_walks_step_aside_and_come_to_the_same_end() -> None:
    ground, solids = ClearanceRaster.of(CROSSING), Solids.of(CROSSING)
    found = walks(ground, WAY, START, TARGET)
    assert sum(walk != WAY for walk in found) > 20
    assert sum(sum(action in TURNS for action in walk) for walk in found) > 40 * 5
    for walk in found:
        path, end = follow_actions(START, walk)
        right, ahead = end.local(*TARGET)
        assert sum(TURNS.get(action, 0) for action in walk) == 3
        assert REACH_FROM <= ahead <= REACH_TO
        assert abs(right) <= 0.5
        places = np.array(path)
        dense = np.concatenate([places[:-1] + share * np.diff(places, axis=0) for share in np.linspace(0, 1, 21)])
        assert solids.distance(dense).min() > 0.26
        assert all(min(abs(x), abs(z)) <= MAX_OFFSET + 0.6 for x, z in path)  # Half a step more after the corner.
        assert walk[0] is walk[1] is Action.FORWARD


def test_walks_are_the_same_for_the_same_names() -> None:
    ground = ClearanceRaster.of(CROSSING)
    assert walks(ground, WAY, START, TARGET) == walks(ground, WAY, START, TARGET)


def test_alleys_that_leave_no_room_are_walked_straight() -> None:
    walls = tuple(Building(x, 0.0, 1.0, 12.0, 0.0, 2.0, "brick") for x in (-1.7, 1.7))
    ground = ClearanceRaster.of(Section("8", 0.0, (-5.0, -13.0, 5.0, 13.0), walls, ()))
    way = [Action.FORWARD] * 18

    assert all(walk == way for walk in walks(ground, way, Pose(0.0, -10.0, 0.0), (0.0, 9.5)))


def test_streets_at_any_angle_are_steered_in_as_well() -> None:
    angle = 17.0
    sin, cos = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    blocks = tuple(Building(s * 6 * cos, -s * 6 * sin, 3.0, 20.0, angle, 2.0, "brick") for s in (-1, 1))
    ground = ClearanceRaster.of(Section("8", angle, (-15.0, -25.0, 15.0, 25.0), blocks, ()))
    way, start = [Action.FORWARD] * 18, Pose(-10.0 * sin, -10.0 * cos, angle)
    found = walks(ground, way, start, (9.5 * sin, 9.5 * cos))

    assert any(walk != way for walk in found)
    assert all(
        abs(start.local(*place)[0]) <= MAX_OFFSET + 1e-6 for walk in found for place in follow_actions(start, walk)[0]
    )
