"""PPO of Stable-Baselines3 on the vector environment, with a GRU as the text encoder.

    pip install '.[learners]'
    python -m examples.sb3_vector DATA SPLIT [STEPS] [SEED]

`VectorForSB3` makes a `VecEnv` of Stable-Baselines3 from `gymnasium.make_vec`: episodes in several processes, images in
shared memory. `ObservationEncoder` is a features extractor: a small CNN for the view, an embedding and a GRU for the
words of the instruction, one-hot vectors for turn, phase and last action. It shows how the parts fit together, as a
starting point for your own policies; learning to navigate takes millions of steps.
"""

import sys
from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnv, VecMonitor
from torch import nn

import arramon_client.environments  # noqa: F401 - registers the environments

KEYS = ("rgb", "instruction_tokens", "turn", "phase", "last_action")
"""Observation keys. `instruction` is left out, as Stable-Baselines3 does not support texts."""

ENVIRONMENTS, PROCESSES, SIZE = 8, 2, 64
"""Number of parallel episodes, number of processes, and side length of the view in pixels."""

LIMIT = 30
"""Step limit of a phase: a fifth of the benchmark's, so that even an untrained agent reaches turn 2."""

EMBEDDING, HIDDEN = 32, 64
"""Word embedding size, and hidden size of the GRU."""


class VectorForSB3(VecEnv):
    """Adapter from a Gymnasium vector environment in the mode SAME_STEP to Stable-Baselines3's `VecEnv`.

    Args:
        env: from `gymnasium.make_vec(..., autoreset_mode="SameStep")`.
    """

    def __init__(self, env: Any) -> None:
        self._env, self._actions = env, np.zeros(env.num_envs, np.int64)
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> dict[str, Any]:
        """Begin all episodes, and return their first observations."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        observation, infos = self._env.reset(seed=seeds)
        self.reset_infos = self._each(infos)
        self._reset_seeds()
        return dict(observation)

    def step_async(self, actions: Any) -> None:
        """Store the actions of the next step, (num_envs,)."""
        self._actions = actions

    def step_wait(self) -> tuple[dict[str, Any], Any, Any, list[dict[str, Any]]]:
        """Apply the stored actions; the infos of episodes that ended have `terminal_observation`."""
        observation, rewards, terminated, truncated, infos = self._env.step(self._actions)
        each = self._each({name: value for name, value in infos.items() if "final" not in name})
        for number in np.flatnonzero(terminated | truncated):
            each[number]["terminal_observation"] = infos["final_obs"][number]
            each[number]["TimeLimit.truncated"] = bool(truncated[number] and not terminated[number])
        return dict(observation), rewards.astype(np.float32), terminated | truncated, each

    def close(self) -> None:
        """End the worker processes."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """Return an attribute of the vector environment, once for each episode."""
        return [getattr(self._env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None) -> None:
        """Raise NotImplementedError: the episodes are no environments of their own."""
        raise NotImplementedError(f"{attr_name} cannot be set in a vector of episodes")

    def env_method(
        self, method_name: str, *method_args: Any, indices: int | Iterable[int] | None = None, **method_kwargs: Any
    ) -> list[Any]:
        """Raise NotImplementedError: the episodes are no environments of their own."""
        raise NotImplementedError(f"{method_name} cannot be called in a vector of episodes")

    def env_is_wrapped(self, wrapper_class: type, indices: int | Iterable[int] | None = None) -> list[bool]:  # noqa: ARG002
        """Return False for each episode."""
        return [False for _ in self._get_indices(indices)]

    def _each(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        """Return each episode's infos, from Gymnasium's arrays and their masks."""
        return [
            {
                name: value[number]
                for name, value in infos.items()
                if not isinstance(value, dict) and f"_{name}" in infos and infos[f"_{name}"][number]
            }
            for number in range(self.num_envs)
        ]


class ObservationEncoder(BaseFeaturesExtractor):
    """Encoder of observations: a CNN for the view, an embedding and a GRU for the instruction, the rest unchanged.

    Args:
        observation_space: with the keys `KEYS`.
        words: size of the vocabulary, `tokenizer.size`.
    """

    def __init__(self, observation_space: gymnasium.spaces.Dict, words: int) -> None:
        self._others = [key for key in observation_space if key not in ("rgb", "instruction_tokens")]
        numbers = sum(gymnasium.spaces.flatdim(observation_space[key]) for key in self._others)
        super().__init__(observation_space, 128 + HIDDEN + numbers)
        self.view = nn.Sequential(
            nn.Conv2d(3, 16, 8, 4), nn.ReLU(), nn.Conv2d(16, 32, 4, 2), nn.ReLU(), nn.Flatten(),
            nn.LazyLinear(128), nn.ReLU(),
        )  # fmt: skip
        self.view(torch.zeros(1, *(observation_space["rgb"].shape or ())))  # Sets the lazy layer's size.
        self.embedding = nn.Embedding(words, EMBEDDING, padding_idx=0)
        self.gru = nn.GRU(EMBEDDING, HIDDEN, batch_first=True)

    def forward(self, observation: dict[str, torch.Tensor]) -> torch.Tensor:
        """Return the features, (batch, features).

        Stable-Baselines3 passes images as (batch, 3, size, size), turns as one-hot vectors, and numbers as floats.
        """
        tokens = observation["instruction_tokens"].long()
        lengths = (tokens != 0).sum(dim=1).clamp(min=1).cpu()
        packed = nn.utils.rnn.pack_padded_sequence(
            self.embedding(tokens), lengths, batch_first=True, enforce_sorted=False
        )
        _, state = self.gru(packed)  # (1, batch, HIDDEN): after the last word of each instruction.
        others = [observation[key].flatten(1) for key in self._others]
        return torch.cat([self.view(observation["rgb"]), state[0], *others], dim=1)


def make(data: str, split: str, **options: Any) -> Any:
    """Return the vector environment, with instructions in both languages as word ids."""
    given: dict[str, Any] = {
        "processes": PROCESSES, "autoreset_mode": "SameStep", "lang": ("en", "hi"), "observe": KEYS,
        "tokenizer": "words", "image_size": SIZE, "reward": "progress", "steps_per_phase": LIMIT, **options,
    }  # fmt: skip
    return gymnasium.make_vec("arramon/ArraMon-v0", ENVIRONMENTS, data=data, split=split, **given)


def main(arguments: Sequence[str]) -> None:
    """Train, and print the mean return of the latest episodes."""
    data, split, *numbers = arguments
    steps, seed = map(int, [*numbers, *("100000", "0")[len(numbers) :]])
    inner = make(data, split)
    env = VecMonitor(VectorForSB3(inner))
    model = PPO(
        "MultiInputPolicy", env, n_steps=128, batch_size=256, n_epochs=4, learning_rate=3e-4, seed=seed, device="cpu",
        policy_kwargs={
            "features_extractor_class": ObservationEncoder,
            "features_extractor_kwargs": {"words": inner.tokenizer.size},
            "net_arch": [128],
        },
    )  # fmt: skip
    model.learn(steps)
    returns = [episode["r"] for episode in model.ep_info_buffer or ()]
    print(f"{model.num_timesteps} steps, {len(returns)} episodes, mean return {np.mean(returns):.2f}")
    env.close()


if __name__ == "__main__":
    main(sys.argv[1:])
