"""What stops a plan: unexpected effects of an action."""

from dataclasses import replace

import numpy as np
import pytest

from arramon_client import Observation
from arramon_client.runs.live_episode import stop_reason
from arramon_client.world import Action

NOTHING = Observation("e", 1, "navigation", 3, "go", 3, 147)
POSE = replace(NOTHING, pose=(1.0, 2.0, 30.0))
BLACK, WHITE = np.zeros((2, 2, 3), np.uint8), np.full((2, 2, 3), 255, np.uint8)
NEAR, FAR = np.ones((2, 2), np.float32), np.full((2, 2), 2.0, np.float32)
SEEN = replace(NOTHING, rgb=BLACK, depth=NEAR)


@pytest.mark.parametrize(
    ("before", "action", "after", "reason"),
    [
        (POSE, Action.FORWARD, POSE, "blocked"),
        (POSE, Action.FORWARD, replace(POSE, pose=(1.0, 3.0, 30.0)), ""),
        (POSE, Action.LEFT, replace(POSE, pose=(1.0, 2.0, 0.0)), ""),
        (replace(POSE, rgb=BLACK), Action.FORWARD, replace(POSE, rgb=WHITE), "blocked"),
        (replace(POSE, rgb=BLACK), Action.FORWARD, replace(POSE, rgb=BLACK, pose=(1.0, 3.0, 30.0)), ""),
        (SEEN, Action.FORWARD, SEEN, "blocked"),
        (SEEN, Action.FORWARD, replace(SEEN, depth=FAR), ""),
        (SEEN, Action.FORWARD, replace(SEEN, rgb=WHITE), ""),
        (SEEN, Action.RIGHT, SEEN, ""),
        (NOTHING, Action.FORWARD, NOTHING, ""),
        (NOTHING, Action.INTERACT, NOTHING, "no pick-up"),
        (NOTHING, Action.INTERACT, replace(NOTHING, phase="assembly"), "phase over"),
        (SEEN, Action.FORWARD, replace(SEEN, turn=2), "phase over"),
    ],
)
def test_unexpected_effects(before: Observation, action: int, after: Observation, reason: str) -> None:
    assert stop_reason(before, action, after) == reason
