"""The agent: reads and sees by what it has learned, by RGB and depth alone, many episodes at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from agents.learning.vision import FrameMemory, resize
from agents.learning.vision_eyes import Eyes
from agents.vl_grounded.placer import Placer
from agents.vl_grounded.walker import Walker
from agents.vl_grounded.weights import Weights
from arramon_client.agent import Episode, Observation
from arramon_client.environments.backend import NAVIGATION

NAME = "vl_grounded"


@dataclass(frozen=True)
class _Phase:
    """A phase that is played: which it is, and by what."""

    turn: int
    name: str
    player: Walker | Placer


class GroundedAgent:
    """Agent that grounds what it reads in what it sees, step by step.

    Args:
        weights: of its networks.
        eyes: the visual encoder that they were trained on.
    """

    name = NAME
    sensors = ("rgb", "depth")

    def __init__(self, weights: Weights, eyes: Eyes) -> None:
        self._weights, self._eyes = weights, eyes
        self._frames = FrameMemory(eyes)
        self._phases: dict[str, _Phase] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        self._phases.pop(episode.episode_id, None)

    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Return one action for each observation.

        Raises:
            ValueError: if an observation has no RGB or no depth.
        """
        actions = [0] * len(observations)
        walking: list[tuple[int, Walker]] = []
        for number, observation in enumerate(observations):
            player = self._player(observation)
            if isinstance(player, Walker):
                walking.append((number, player))
            else:
                actions[number] = self._place(player, observation)
        if walking:
            images = [_images(observations[number]) for number, _ in walking]
            rgb, depth = (np.stack(part) for part in zip(*images, strict=True))
            for (number, walker), features, ahead in zip(
                walking, self._frames.features(rgb, depth), depth, strict=True
            ):
                actions[number] = walker.act(features, ahead)
        return actions

    def _place(self, placer: Placer, observation: Observation) -> int:
        rgb, depth = _images(observation)
        things = []
        if placer.looks:
            things = self._eyes.things(*resize(rgb[None], depth[None], self._eyes.image_size))[0]
        return placer.act(things, observation.steps_left)

    def _player(self, observation: Observation) -> Walker | Placer:
        """Return what plays the present phase of an episode."""
        phase = self._phases.get(observation.episode_id)
        if phase is None or (phase.turn, phase.name) != (observation.turn, observation.phase):
            tokens = torch.tensor([self._weights.tokenizer.encode(observation.instruction)])
            make = Walker if observation.phase == NAVIGATION else Placer
            phase = _Phase(observation.turn, observation.phase, make(self._weights.network, tokens))
            self._phases[observation.episode_id] = phase
        return phase.player


def _images(observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    if observation.rgb is None or observation.depth is None:
        raise ValueError("vl_grounded requires the sensors rgb and depth, which this run does not have")
    return observation.rgb, observation.depth
