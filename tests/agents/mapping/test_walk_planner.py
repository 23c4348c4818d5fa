"""Plans of walks on the agent's own map."""

import math

import numpy as np
import pytest

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.motion import STEPS, can_step, step_key
from arramon_agents.mapping.walk_planner import Circle, Goal, Line, PickUp, plan_walk
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

NONE = np.empty((0, 2))


def body_in_street(left: float, right: float, length: float = 24.0, heading: int = 0) -> AgentBody:
    """An agent at (0, 0) in a street along z, whose walls are at x = `left` and x = `right`."""
    body = AgentBody(())
    body.heading = heading
    for z in np.arange(-4.0, length, 0.25):
        body.ground.block(left, float(z))
        body.ground.block(right, float(z))
    return body


def walked(body: AgentBody, goal: Goal) -> list[tuple[float, float, int]]:
    """The poses of a planned walk, the first included."""
    x, z, heading = body.pose
    poses = [(x, z, heading)]
    for action in plan_walk(body, goal):
        heading = (heading + {Action.LEFT: -1, Action.RIGHT: 1}.get(action, 0)) % HEADINGS
        if action is Action.FORWARD:
            assert can_step(body.ground, x, z, heading)
            x, z = x + STEPS[heading][0], z + STEPS[heading][1]
        poses.append((x, z, heading))
    return poses


def test_a_walk_leaves_the_wall_for_the_middle_of_the_street() -> None:
    body = body_in_street(-0.75, 5.0)
    xs = [x for x, z, _ in walked(body, Line(0.0, 14.0, 0.0, 4.0)) if 4.0 < z < 11.0]
    assert xs
    assert all(0.9 < x < 3.5 for x in xs)  # The middle is at 2.1.


def test_a_walk_in_the_middle_of_a_wide_street_is_straight() -> None:
    assert plan_walk(body_in_street(-3.0, 3.0), Line(0.0, 9.5, 0.0, 2.5)) == [Action.FORWARD] * 10


@pytest.mark.parametrize("aside", [0.4, 2.5])
def test_a_walk_to_a_line_stays_near_the_course(aside: float) -> None:
    body = body_in_street(-0.75, 5.0)
    poses = walked(body, Line(0.0, 9.0, 0.0, aside))
    assert poses[-1][1] >= 9.0
    assert max(abs(x) for x, _, _ in poses) <= aside


def test_a_walk_goes_around_obstacles() -> None:
    body = AgentBody(())
    for i in range(-8, 9):
        body.ground.block(i * 0.25, 3.0)
    assert not can_step(body.ground, 0.0, 2.0, 0)
    poses = walked(body, Circle(0.0, 6.0, 0.6))
    assert math.hypot(poses[-1][0], poses[-1][1] - 6.0) <= 0.6
    assert max(abs(x) for x, _, _ in poses) > 2.0


def test_a_walk_avoids_steps_that_turned_out_to_be_blocked() -> None:
    body = AgentBody(())
    body.closed_steps = frozenset({step_key(0.0, 0.0, 0)})
    actions = plan_walk(body, Circle(0.0, 6.0, 0.6))
    assert actions[0] is not Action.FORWARD
    assert Action.FORWARD in actions


def test_a_walk_avoids_unseen_ground() -> None:
    body = body_in_street(-6.0, 6.0)
    free = np.frombuffer(body.ground.free, np.uint8).reshape(640, 640)
    free[320 + 8 : 320 + 20, 312:400] = 1  # From x = 2 to x = 5 the ground was seen.
    free[312:400, 312:328] = 1  # So was the way across, from z = -2 to z = 2.
    xs = [x for x, z, _ in walked(body, Line(0.0, 16.0, 0.0, 5.0)) if 5.0 < z < 14.0]
    assert min(xs) >= 2.0


def test_the_plan_is_empty_at_the_goal() -> None:
    assert plan_walk(AgentBody(()), Circle(0.3, 0.3, 0.6)) == []


def test_the_plan_to_an_enclosed_place_ends_near_it() -> None:
    body = AgentBody(())
    for angle in np.arange(0.0, 2.0 * math.pi, 0.05):
        body.ground.block(8.0 + 2.0 * math.cos(angle), 2.0 * math.sin(angle))
    poses = walked(body, Circle(8.0, 0.0, 0.5))
    assert 2.0 < math.hypot(poses[-1][0] - 8.0, poses[-1][1]) < 4.0


def test_a_walk_to_an_object_ends_where_a_pick_up_takes_it() -> None:
    x, z, heading = walked(AgentBody(()), PickUp(4.0, 3.0, NONE))[-1]
    sin, cos = STEPS[heading]
    right, ahead = (4.0 - x) * cos - (3.0 - z) * sin, (4.0 - x) * sin + (3.0 - z) * cos
    assert abs(right) <= 0.42
    assert 0.8 <= ahead <= 1.9


def test_a_walk_to_an_object_ends_where_no_other_is_nearer() -> None:
    other = np.array([[0.0, 4.0]])
    alone = walked(AgentBody(()), PickUp(0.0, 5.0, NONE))
    beside = walked(AgentBody(()), PickUp(0.0, 5.0, other))
    assert alone[-1][2] == 0
    x, z, _ = beside[-1]
    assert math.hypot(x, z - 4.0) > math.hypot(x, z - 5.0) or beside[-1][2] != 0
    assert len(beside) > len(alone)
