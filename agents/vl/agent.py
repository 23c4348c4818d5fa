"""The agent that plays with trained weights: many episodes at a time, on any split, from RGB and depth alone."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from arramon_agents.perception.encoder import GRID, FeatureCache
from arramon_agents.vl.model import ACTIONS, START_ACTION, State, Text, as_input
from arramon_agents.vl.policy import VlPolicy
from arramon_client.agent import Episode, Observation


@dataclass
class _PhaseState:
    """State of an episode's current phase: its name, its encoded instruction, and the model's recurrent state."""

    phase: tuple[int, str]
    words: Tensor  # (T, H)
    state: State | None = None
    before: int = START_ACTION


class LearnedAgent:
    """Agent that plays by a trained policy.

    Args:
        policy: the model with its tokenizer and visual encoder.
        name: shown on the leaderboard.
        seed: for sampling actions.
        temperature: of the softmax from which actions are sampled; 0 takes the best action. The random numbers are
            hashes of seed, episode and step, so that a resumed run samples the same actions.
    """

    def __init__(self, policy: VlPolicy, name: str, seed: int = 0, temperature: float = 0.0) -> None:
        self.name = name
        self.sensors = () if policy.encoder is None else ("rgb", "depth")
        self._policy, self._seed, self._temperature = policy, seed, temperature
        self._frames = None if policy.encoder is None else FeatureCache(policy.encoder)
        self._memories: dict[str, _PhaseState] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        self._memories.pop(episode.episode_id, None)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode; there is none before its first step."""
        self._memories.pop(episode_id, None)

    @torch.inference_mode()
    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Return one action for each observation."""
        features = self._see(observations)
        actions = [0] * len(observations)
        for phase in {observation.phase for observation in observations}:
            chosen = [number for number, observation in enumerate(observations) if observation.phase == phase]
            values = self._ask(phase, [observations[number] for number in chosen], features[chosen])
            for number, row in zip(chosen, values, strict=True):
                actions[number] = self._choose(observations[number], row)
                self._memories[observations[number].episode_id].before = actions[number]
        return actions

    def _see(self, observations: Sequence[Observation]) -> Tensor:
        """Return the features of the images, (B, 7, 7, C)."""
        if self._frames is None:
            return torch.zeros(len(observations), GRID, GRID, 0)
        rgb = np.stack([_image_of(observation, "rgb") for observation in observations])
        depth = np.stack([_image_of(observation, "depth") for observation in observations])
        return as_input(self._frames.features(rgb, depth))

    def _ask(self, phase: str, observations: Sequence[Observation], features: Tensor) -> Tensor:
        """Return the logits of all actions in one phase, (B, 4), and keep the model's states."""
        memories = [self._remember(observation) for observation in observations]
        module = self._policy.model.of(phase)
        text = _pad_texts([memory.words for memory in memories])
        before = torch.tensor([[memory.before] for memory in memories])
        values, state = module.act(text, features[:, None], before, _stack_states(memories, module.config.hidden))
        for number, memory in enumerate(memories):
            memory.state = state[0][:, number], state[1][:, number]
        return values[:, 0, :ACTIONS]

    def _remember(self, observation: Observation) -> _PhaseState:
        memory = self._memories.get(observation.episode_id)
        phase = observation.turn, observation.phase
        if memory is None or memory.phase != phase:
            tokens = torch.tensor([self._policy.tokenizer.encode(observation.instruction)])
            memory = _PhaseState(phase, self._policy.model.of(observation.phase).read(tokens).words[0])
            self._memories[observation.episode_id] = memory
        return memory

    def _choose(self, observation: Observation, values: Tensor) -> int:
        if self._temperature <= 0:
            return int(values.argmax())
        digest = hashlib.blake2b(f"{self._seed}/{observation.step}/{observation.episode_id}".encode(), digest_size=8)
        threshold = int.from_bytes(digest.digest()) / 2**64
        shares = (values / self._temperature).softmax(-1).cumsum(-1)
        return min(int((shares < threshold).sum()), ACTIONS - 1)


def _image_of(observation: Observation, sensor: str) -> npt.NDArray[np.generic]:
    image = getattr(observation, sensor)
    if image is None:
        raise ValueError(f"the observation has no {sensor}, which the agent needs: run it with --sensors rgb,depth")
    return np.asarray(image)


def _pad_texts(texts: Sequence[Tensor]) -> Text:
    """Return texts of different lengths as one padded batch."""
    padded = torch.nn.utils.rnn.pad_sequence(list(texts), batch_first=True)
    lengths = torch.tensor([len(text) for text in texts])
    return Text(padded, torch.arange(padded.shape[1]) >= lengths[:, None])


def _stack_states(memories: Sequence[_PhaseState], hidden: int) -> State:
    """Return the states of several episodes as one batch; before the first step a state is 0."""
    blank = torch.zeros(1, hidden), torch.zeros(1, hidden)
    states = [memory.state or blank for memory in memories]
    first = torch.stack([state[0] for state in states], 1)
    second = torch.stack([state[1] for state in states], 1)
    return first, second
