"""TorchRL: an episode with its texts, then PPO on the vector environment.

    pip install '.[learners]'
    python -m examples.torchrl_ppo DATA SPLIT [STEPS] [SEED]

A single environment is `torchrl.envs.GymEnv("arramon/ArraMon-v0", ...)`, which returns texts unchanged. A vector needs
`autoreset_mode="Disabled"`, and for texts `VectorWithTexts`, as TorchRL 0.14 treats the texts of a batch as one value
(also with Gymnasium's own vectors). The policy here is small, and sees neither image nor text: the example only shows
how the parts fit together.
"""

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import torch
from tensordict import NonTensorStack, TensorDict
from tensordict.nn import TensorDictModule, TensorDictSequential
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs import GymEnv, GymWrapper, TransformedEnv
from torchrl.envs.transforms import CatTensors, DoubleToFloat, DTypeCastTransform
from torchrl.modules import OneHotCategorical, ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

import arramon_client.environments  # noqa: F401 - registers the environments

TEXT = "instruction"

KEYS = ("turn", "phase", "last_action", "steps_left", "pose")
"""What the policy observes."""

ENVIRONMENTS, FRAMES, EPOCHS = 4, 256, 4
"""Number of parallel episodes; total number of steps between two updates; epochs over these."""


class VectorWithTexts(GymWrapper):  # type: ignore[misc]  # TorchRL has no types
    """A vector environment whose instructions are a stack of texts, one for each episode."""

    def read_obs(self, observations: Mapping[str, Any]) -> dict[str, Any]:
        """Return the observations as tensors, and the texts as they are."""
        read = super().read_obs({name: value for name, value in observations.items() if name != TEXT})
        return {**read, TEXT: NonTensorStack(*observations[TEXT])} if TEXT in observations else read


def make_vector(data: str, split: str, **options: Any) -> VectorWithTexts:
    """Return the vector environment for TorchRL."""
    return VectorWithTexts(
        gymnasium.make_vec(
            "arramon/ArraMon-v0", ENVIRONMENTS, autoreset_mode="Disabled", data=data, split=split, **options
        )
    )


def instructions(data: str, split: str) -> list[str]:
    """Play an episode with random actions, and return its instructions in order."""
    env = GymEnv("arramon/ArraMon-v0", data=data, split=split, observe=(TEXT, "turn"), steps_per_phase=3)
    rollout = env.rollout(100)
    return list(dict.fromkeys(rollout[TEXT]))


def networks(env: Any) -> tuple[Any, Any]:
    """Return the policy and the value network, whose input is the concatenated observation."""
    size = env.observation_spec["state"].shape[-1]
    policy = TensorDictModule(
        nn.Sequential(nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 4)), in_keys=["state"], out_keys=["logits"]
    )
    actor = ProbabilisticActor(
        policy, in_keys=["logits"], out_keys=["action"], spec=env.action_spec, distribution_class=OneHotCategorical,
        return_log_prob=True,
    )  # fmt: skip
    value = ValueOperator(nn.Sequential(nn.Linear(size, 64), nn.Tanh(), nn.Linear(64, 1)), in_keys=["state"])
    return actor, value


def learn(env: Any, steps: int, seed: int) -> tuple[int, float]:
    """Train with PPO; return the number of steps in turn 2, and the mean reward of the last batch."""
    torch.manual_seed(seed)
    env.set_seed(seed)
    actor, value = networks(env)
    loss_of, advantage = ClipPPOLoss(actor, value), GAE(gamma=0.99, lmbda=0.95, value_network=value)
    optimizer = torch.optim.Adam(TensorDictSequential(actor, value).parameters(), lr=1e-3)
    second, reward = 0, 0.0
    collector = Collector(
        env, actor, frames_per_batch=FRAMES, total_frames=steps, auto_register_policy_transforms=False
    )  # fmt: skip
    for batch in collector:
        second += int((batch["turn"].argmax(-1) == 2).sum())
        reward = float(batch["next", "reward"].mean())
        for _ in range(EPOCHS):
            advantage(batch)
            losses: TensorDict = loss_of(batch.reshape(-1))
            loss = losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
    return second, reward


def main(arguments: Sequence[str]) -> None:
    """Print the instructions of an episode, train, and print the mean reward."""
    data, split, *numbers = arguments
    steps, seed = map(int, [*numbers, *("20480", "0")[len(numbers) :]])
    print("instructions:", *instructions(data, split), sep="\n  ")
    with_texts = make_vector(data, split, observe=(TEXT, "turn"), lang=("en", "hi"), steps_per_phase=3)
    texts = with_texts.rollout(4, break_when_any_done=False)[TEXT]
    print(f"a vector's texts: {len(texts)} episodes, {len(texts[0])} steps")
    with_texts.close()
    vector = make_vector(data, split, observe=KEYS, sensors=("pose",), reward="progress", steps_per_phase=20)
    env = TransformedEnv(vector)
    env.append_transform(DTypeCastTransform(torch.int64, torch.float32, in_keys=list(KEYS[:3])))
    env.append_transform(DTypeCastTransform(torch.int32, torch.float32, in_keys=["steps_left"]))
    env.append_transform(DoubleToFloat(in_keys=["pose"]))
    env.append_transform(CatTensors(in_keys=list(KEYS), out_key="state", del_keys=False))
    second, reward = learn(env, steps, seed)
    print(f"{steps} steps, {second} of them in turn 2, mean reward {reward:.4f}")
    env.close()


if __name__ == "__main__":
    main(sys.argv[1:])
