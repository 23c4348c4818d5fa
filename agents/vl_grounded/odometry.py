"""Odometry features: the agent's pose relative to the start, by dead reckoning from its own actions."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Action
from arramon_client.world import HEADINGS

ODOMETRY_SIZE = HEADINGS + 7
"""Number of features: one-hot heading; position of the start relative to the agent, and its distance; steps since the
last turn; turns to the right since the last step; steps and actions so far."""


def odometry(actions: Sequence[int]) -> npt.NDArray[np.float32]:
    """Return the odometry features before and after each action, (n + 1, ODOMETRY_SIZE), scaled to about 1.

    Args:
        actions: the actions of a navigation phase, without blocked steps.
    """
    rows = np.zeros((len(actions) + 1, ODOMETRY_SIZE), np.float32)
    x = z = 0.0
    heading = ahead = turned = walked = 0
    for number in range(len(actions) + 1):
        sin, cos = math.sin(heading * math.pi / 6), math.cos(heading * math.pi / 6)
        right, front = x * cos - z * sin, x * sin + z * cos
        rows[number, heading] = 1.0
        rows[number, HEADINGS:] = (
            -right / 10, -front / 10, math.hypot(x, z) / 20, min(ahead, 20) / 10, turned / 6, walked / 30, number / 50,
        )  # fmt: skip
        if number == len(actions):
            break
        action = actions[number]
        if action == Action.FORWARD:
            x, z, ahead, turned, walked = x + sin, z + cos, ahead + 1, 0, walked + 1
        elif action in (Action.LEFT, Action.RIGHT):
            turn = 1 if action == Action.RIGHT else -1
            heading, turned, ahead = (heading + turn) % HEADINGS, turned + turn, 0
    return rows
