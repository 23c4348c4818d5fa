"""Collection of rollouts with a vector environment in two processes: examples/collect_rollouts.py [DATA] [SPLIT]"""

import sys
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

import arramon_client.environments  # noqa: F401 - registers the environments

EPISODES, STEPS = 8, 32
"""Number of parallel episodes, and number of steps of a rollout."""


def rollouts(env: Any, policy: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Yield rollouts of STEPS steps of all episodes, arrays of (STEPS, EPISODES, ...); texts as lists of tuples.

    In the mode NEXT_STEP the step after an episode's end only begins the next one: `valid` is False there.
    """
    observation, _ = env.reset(seed=0)
    ended = np.zeros(EPISODES, bool)
    while True:
        steps: list[dict[str, Any]] = []
        for _ in range(STEPS):
            actions = policy.integers(4, size=EPISODES)  # Here your model looks at the observation.
            following, rewards, terminated, _, _ = env.step(actions)
            # What was returned is never written again, so it can be kept without copying it.
            steps.append({**observation, "action": actions, "reward": rewards, "valid": ~ended})
            observation, ended = following, terminated
        yield {
            name: [step[name] for step in steps] if name == "instruction" else np.stack([step[name] for step in steps])
            for name in steps[0]
        }


def main(data: str = "arramon-data", split: str = "val_seen") -> None:
    """Collect three rollouts, and print their shapes."""
    env = gymnasium.make_vec(
        "arramon/ArraMon-v0", EPISODES, processes=2, data=data, split=split, image_size=64, reward="progress"
    )
    for number, rollout in zip(range(3), rollouts(env, np.random.default_rng(0)), strict=False):
        shapes = {name: getattr(value, "shape", len(value)) for name, value in rollout.items()}
        print(f"rollout {number}: mean reward {rollout['reward'].mean():.3f}", shapes)
    env.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
