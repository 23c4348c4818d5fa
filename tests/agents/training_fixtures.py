"""Small recipes, workspaces and random demonstrations for tests of training."""

from pathlib import Path

import numpy as np

from arramon_agents.perception.registry import open_encoder
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.training.workspace import Workspace
from arramon_agents.vl.recipe import Recipe
from arramon_client.world import PHASES


def recipe(agent: str = "vl", *, sees: bool = True, reads: bool = True, validate: int = 0, passes: int = 3) -> Recipe:
    return Recipe(
        agent,
        sees=sees,
        reads=reads,
        encoder="pooled",
        passes=passes,
        batch=2,
        room_batch=3,
        validate_episodes=validate,
        validate_steps=100,
    )


def place(output: Path, data: Path = Path("none"), checkpoint_steps: int = 100) -> Workspace:
    return Workspace(data, output / "cache", output, checkpoint_steps=checkpoint_steps)


def demonstrations(count: int = 6, steps: int = 5) -> list[PhaseDemonstration]:
    """Random features, from which the right action follows: left or right, as text and image say."""
    random = np.random.default_rng(7)
    channels = open_encoder("pooled").channels
    found = []
    for number in range(count):
        for phase in PHASES:
            side = 1 + number % 2
            features = random.integers(0, 256, (steps + number % 3, 7, 7, channels), np.uint8)
            features[..., 0] = 255 * (number % 2)
            texts = {"en": f"go {'left' if side == 1 else 'right'}", "hi": f"{'बाएँ' if side == 1 else 'दाएँ'} जाएँ"}
            actions = np.full(len(features), side, np.uint8)
            actions[-1] = 3
            found.append(PhaseDemonstration(str(number), 1, phase, texts, actions, features))
    return found
