"""The agent `vl_grounded`: plays many episodes at a time with one set of networks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from arramon_agents.vl_grounded.assembly_player import AssemblyPlayer
from arramon_agents.vl_grounded.navigation_player import NavigationPlayer
from arramon_agents.vl_grounded.network import GroundedWeights
from arramon_agents.vl_grounded.perception import Perception
from arramon_client.agent import Episode, Observation
from arramon_client.world import NAVIGATION

NAME = "vl_grounded"


@dataclass(frozen=True)
class _PlayedPhase:
    """The current phase of an episode, and its player."""

    turn: int
    name: str
    player: NavigationPlayer | AssemblyPlayer


class GroundedAgent:
    """Agent that matches the words it attends to with what it sees, at each step.

    Args:
        weights: weights and tokenizer.
        sight: perception of observations.
    """

    name = NAME

    def __init__(self, weights: GroundedWeights, sight: Perception) -> None:
        self.sensors = sight.sensors
        self._weights, self._sight = weights, sight
        self._phases: dict[str, _PlayedPhase] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        self._phases.pop(episode.episode_id, None)
        self._sight.begin(episode)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode; there is no phase before its first step."""
        self._phases.pop(episode_id, None)
        self._sight.end(episode_id)

    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Return one action for each observation.

        Raises:
            ValueError: if an observation lacks a sensor.
        """
        actions = [0] * len(observations)
        walking: list[tuple[int, NavigationPlayer]] = []
        for number, observation in enumerate(observations):
            player = self._player(observation)
            if isinstance(player, NavigationPlayer):
                walking.append((number, player))
                continue
            if player.is_looking():
                self._sight.add(player.look, observation)
            actions[number] = player.act(observation.steps_left)
        if walking:
            features = self._sight.features([observations[number] for number, _ in walking])
            for (number, walker), each in zip(walking, features, strict=True):
                actions[number] = walker.act(each, np.asarray(observations[number].depth))
        return actions

    def _player(self, observation: Observation) -> NavigationPlayer | AssemblyPlayer:
        """Return the player of an episode's current phase."""
        phase = self._phases.get(observation.episode_id)
        if phase is None or (phase.turn, phase.name) != (observation.turn, observation.phase):
            tokens = torch.tensor([self._weights.tokenizer.encode(observation.instruction)])
            player: NavigationPlayer | AssemblyPlayer
            if observation.phase == NAVIGATION:
                player = NavigationPlayer(self._weights.network, tokens)
            else:
                player = AssemblyPlayer(self._weights.network, tokens, self._sight.make_look(observation.episode_id))
            phase = _PlayedPhase(observation.turn, observation.phase, player)
            self._phases[observation.episode_id] = phase
        return phase.player
