"""The agent's moves on its own map: unit steps and turns of 30 degrees."""

import math

import numpy as np

from arramon_agents.mapping import walk_kernel
from arramon_agents.mapping.ground_map import GroundMap
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

TURN = 2.0 * math.pi / HEADINGS
STEPS = tuple((math.sin(TURN * i), math.cos(TURN * i)) for i in range(HEADINGS))


def can_step(ground: GroundMap, x: float, z: float, heading: int) -> bool:
    """Return whether a step from (x, z) is not known to be blocked."""
    return walk_kernel.can_step(np.frombuffer(ground.blocked, np.uint8), x, z, *STEPS[heading])


def turns(heading: int, to: int) -> list[Action]:
    """Return the shortest sequence of turns from one heading to another."""
    difference = (to - heading) % HEADINGS
    if difference <= HEADINGS // 2:
        return [Action.RIGHT] * difference
    return [Action.LEFT] * (HEADINGS - difference)


def step_key(x: float, z: float, heading: int) -> tuple[int, int, int]:
    """Return a key of the step that starts at a pose, robust to rounding."""
    return round(x * 10), round(z * 10), heading
