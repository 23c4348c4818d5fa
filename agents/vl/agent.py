"""Agent that plays by a trained model, many episodes at a time, from RGB and depth alone."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from arramon_agents.perception.encoder import GRID, FeatureCache
from arramon_agents.vl.model import ACTIONS, START_ACTION, EncodedText, State, as_input
from arramon_agents.vl.policy import VlPolicy
from arramon_client.agent import Episode, Observation


@dataclass
class _EncodedPhase:
    """State of an episode's current phase: turn and phase name, encoded instruction, history state, last action."""

    phase: tuple[int, str]
    words: Tensor  # (T, H)
    history: State | None = None
    previous_action: int = START_ACTION


class LearnedAgent:
    """Agent that plays by a trained policy.

    Args:
        policy: the model with its tokenizer and visual encoder.
        name: name on the leaderboard.
        seed: seed for sampling actions.
        temperature: softmax temperature for sampling actions; 0 takes the best action. The random numbers are hashes of
            seed, episode and step, so a resumed run samples the same actions.
    """

    def __init__(self, policy: VlPolicy, name: str, seed: int = 0, temperature: float = 0.0) -> None:
        self.name = name
        self.sensors = () if policy.encoder is None else ("rgb", "depth")
        self._policy, self._seed, self._temperature = policy, seed, temperature
        self._frames = None if policy.encoder is None else FeatureCache(policy.encoder)
        self._phases: dict[str, _EncodedPhase] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        self._phases.pop(episode.episode_id, None)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode, if it has any."""
        self._phases.pop(episode_id, None)

    @torch.inference_mode()
    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Return one action for each observation."""
        features = self._encode_images(observations)
        actions = [0] * len(observations)
        for phase in {observation.phase for observation in observations}:
            rows = [row for row, observation in enumerate(observations) if observation.phase == phase]
            logits = self._logits(phase, [observations[row] for row in rows], features[rows])
            for row, action_logits in zip(rows, logits, strict=True):
                actions[row] = self._sample_action(observations[row], action_logits)
                self._phases[observations[row].episode_id].previous_action = actions[row]
        return actions

    def _encode_images(self, observations: Sequence[Observation]) -> Tensor:
        """Return the visual features of the observations, (B, 7, 7, C)."""
        if self._frames is None:
            return torch.zeros(len(observations), GRID, GRID, 0)
        rgb = np.stack([_image_of(observation, "rgb") for observation in observations])
        depth = np.stack([_image_of(observation, "depth") for observation in observations])
        return as_input(self._frames.features(rgb, depth))

    def _logits(self, phase: str, observations: Sequence[Observation], features: Tensor) -> Tensor:
        """Return the action logits for observations of one phase, (B, 4), and advance their history states."""
        states = [self._phase_state(observation) for observation in observations]
        model = self._policy.model.of(phase)
        text = _pad_texts([state.words for state in states])
        previous_actions = torch.tensor([[state.previous_action] for state in states])
        history = _stack_histories(states, model.config.hidden)
        logits, (hidden, cell) = model.act(text, features[:, None], previous_actions, history)
        for row, state in enumerate(states):
            state.history = hidden[:, row], cell[:, row]
        return logits[:, 0, :ACTIONS]

    def _phase_state(self, observation: Observation) -> _EncodedPhase:
        """Return the state of the observation's phase, with its instruction encoded once, at the first step."""
        state = self._phases.get(observation.episode_id)
        phase = observation.turn, observation.phase
        if state is None or state.phase != phase:
            tokens = torch.tensor([self._policy.tokenizer.encode(observation.instruction)])
            state = _EncodedPhase(phase, self._policy.model.of(observation.phase).read(tokens).words[0])
            self._phases[observation.episode_id] = state
        return state

    def _sample_action(self, observation: Observation, logits: Tensor) -> int:
        """Return the best action, or one sampled from the softmax if the temperature is above 0."""
        if self._temperature <= 0:
            return int(logits.argmax())
        digest = hashlib.blake2b(f"{self._seed}/{observation.step}/{observation.episode_id}".encode(), digest_size=8)
        threshold = int.from_bytes(digest.digest()) / 2**64
        cumulative = (logits / self._temperature).softmax(-1).cumsum(-1)
        return min(int((cumulative < threshold).sum()), ACTIONS - 1)


def _image_of(observation: Observation, sensor: str) -> npt.NDArray[np.generic]:
    image = getattr(observation, sensor)
    if image is None:
        raise ValueError(f"the observation has no {sensor}, which the agent needs: run it with --sensors rgb,depth")
    return np.asarray(image)


def _pad_texts(texts: Sequence[Tensor]) -> EncodedText:
    """Return encoded texts of different lengths as one padded batch."""
    padded = torch.nn.utils.rnn.pad_sequence(list(texts), batch_first=True)
    lengths = torch.tensor([len(text) for text in texts])
    return EncodedText(padded, torch.arange(padded.shape[1]) >= lengths[:, None])


def _stack_histories(states: Sequence[_EncodedPhase], size: int) -> State:
    """Return the history states of several episodes as one batch; zeros before the first step."""
    zeros = torch.zeros(1, size), torch.zeros(1, size)
    histories = [state.history or zeros for state in states]
    hidden = torch.stack([history[0] for history in histories], 1)
    cell = torch.stack([history[1] for history in histories], 1)
    return hidden, cell
