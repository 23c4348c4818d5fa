"""The heading in which the reference walk of a turn ends, estimated on a literal map of two streets."""

import math

import numpy as np
import pytest

from arramon_agents.follower.known_ground import KnownGround
from arramon_agents.follower.reference_walk import last_heading
from arramon_agents.mapping.ground_map import GroundMap
from arramon_agents.mapping.motion import TURN
from arramon_agents.mapping.street_axis import street_axis
from arramon_agents.perception.scan import Floats, Scan

GRAIN = 0.2
"""Distance of the points of the map, in units."""


def points(x0: float, z0: float, x1: float, z1: float) -> Floats:
    """Points of a rectangle, a line if two of its sides are equal."""
    xs, zs = (np.arange(start, end + GRAIN, GRAIN, dtype=np.float32) for start, end in ((x0, x1), (z0, z1)))
    return np.stack(np.meshgrid(xs, zs), axis=-1).reshape(-1, 2)


def town(turned: int = 0) -> GroundMap:
    """A street of 6 units' width ahead, whose end at z = 20 opens into a street to the left and to the right.

    Args:
        turned: angle of the streets to the agent's first heading, in multiples of 30 degrees.
    """
    free = np.concatenate([points(-3, -3, 3, 20), points(-20, 14, 20, 20)])
    walls = np.concatenate(
        [
            points(-3, -3, -3, 14), points(3, -3, 3, 14), points(-20, 14, -3, 14), points(3, 14, 20, 14),
            points(-20, 20, 20, 20), points(-3, -3, 3, -3),
        ]
    )  # fmt: skip
    sin, cos = math.sin(turned * TURN), math.cos(turned * TURN)
    turn = np.array([[cos, -sin], [sin, cos]], dtype=np.float32)
    ground = GroundMap()
    ground.add(Scan(walls @ turn, np.ones(len(walls), bool), free @ turn))
    return ground


@pytest.mark.parametrize(
    ("target", "heading"),
    [
        ((0.0, 10.5), 0),
        ((0.3, 10.5), 0),
        ((12.5, 17.4), 3),
        ((12.5, 17.0), 2),  # It walks along z = 16, and turns at the end.
        ((-12.5, 17.0), 10),
        ((0.0, -2.5), 6),
    ],
)
def test_walk_follows_the_streets_and_ends_facing_the_object(target: tuple[float, float], heading: int) -> None:
    assert last_heading(town(), target) == heading


def test_object_behind_walls_has_no_walk() -> None:
    assert last_heading(town(), (12.5, 5.0)) is None


def test_object_outside_the_map_has_no_walk() -> None:
    assert last_heading(town(), (70.0, 70.0)) is None


@pytest.mark.parametrize("turned", [0, 1, 2])
def test_direction_of_streets_is_that_of_the_walls(turned: int) -> None:
    assert street_axis(town(turned)) == turned


def test_direction_of_streets_is_the_first_heading_without_walls() -> None:
    assert street_axis(GroundMap()) == 0


def test_steps_cost_more_at_walls_and_on_unseen_ground_and_none_leads_through_a_wall() -> None:
    known = KnownGround(town())
    middle, beside = known.step_cost(0.0, 5.0, 0.0, 1.0), known.step_cost(2.0, 5.0, 0.0, 1.0)
    assert middle == pytest.approx(1.0, abs=0.02)
    assert beside is not None
    assert beside > 1.2
    unseen = known.step_cost(0.0, 21.5, 1.0, 0.0)
    assert unseen is not None
    assert unseen > 3.0
    assert known.step_cost(2.3, 5.0, 1.0, 0.0) is None
    assert known.step_cost(60.0, 5.0, 1.0, 0.0) is None
