"""The agent's moves on its own map: unit steps and turns of 30 degrees."""

import math

from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

TURN = 2.0 * math.pi / HEADINGS
STEPS = tuple((math.sin(TURN * i), math.cos(TURN * i)) for i in range(HEADINGS))

Pose = tuple[float, float, int]
"""(x, z) in the agent's own frame, and the heading in multiples of 30 degrees clockwise from its first heading."""


def can_step(ground: GroundMap, x: float, z: float, heading: int) -> bool:
    """Return whether a step from (x, z) is not known to be blocked."""
    sin, cos = STEPS[heading]
    blocked = ground.blocked
    half = SIDE / 2
    # The agent may be closer to obstacles than its map allows, so ignore a blocked cell right next to it.
    for share in (0.5, 0.75, 1.0, 0.25):
        row, column = int((x + share * sin) / CELL + half), int((z + share * cos) / CELL + half)
        if not (0 <= row < SIDE and 0 <= column < SIDE):
            return False
        if blocked[row * SIDE + column]:
            return share == 0.25 and bool(blocked[int(x / CELL + half) * SIDE + int(z / CELL + half)])
    return True


def turns(heading: int, to: int) -> list[Action]:
    """Return the shortest sequence of turns from one heading to another."""
    difference = (to - heading) % HEADINGS
    if difference <= HEADINGS // 2:
        return [Action.RIGHT] * difference
    return [Action.LEFT] * (HEADINGS - difference)


def step_key(x: float, z: float, heading: int) -> tuple[int, int, int]:
    """Return a key of the step that starts at a pose, robust to rounding."""
    return round(x * 10), round(z * 10), heading
