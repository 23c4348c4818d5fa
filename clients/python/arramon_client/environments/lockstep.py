"""The vector environment in lockstep, Gymnasium's standard interface: each step waits for all episodes."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from arramon_client.agent import Label
from arramon_client.environments.arguments import is_whole_number, whole_number
from arramon_client.environments.batches import VectorBatch
from arramon_client.environments.call_checks import check_actions, episode_starts
from arramon_client.environments.conversion import keep_texts_in_wrappers
from arramon_client.environments.errors import BadArgument, CannotCopy
from arramon_client.environments.group import VectorSettings
from arramon_client.environments.labels import FactoredLabels, factored
from arramon_client.environments.options import make_options
from arramon_client.environments.pool import Pool
from arramon_client.environments.registration import PlainSpec
from arramon_client.environments.spaces import Dict, action_space
from arramon_client.environments.tokens import Tokenizer
from arramon_client.environments.worker import context_of

OWN_ARGUMENTS = ("num_envs", "processes", "autoreset_mode", "context", "render_mode", "batch_size", "max_episode_steps")
"""Arguments of vector environments that a single environment does not have."""

VectorStep = tuple[Dict, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]


class LockstepVectorEnv(PlainSpec, VectorEnv[Dict, npt.NDArray[np.int64], npt.NDArray[Any]]):
    """Several episodes that step together. `vector.ArraMonVectorEnv` documents the arguments.

    Attributes:
        tokenizer: tokenizer of the instructions.
    """

    def __init__(
        self,
        num_envs: int,
        processes: int,
        autoreset_mode: AutoresetMode | str,
        context: str | None,
        render_mode: str | None,
        max_episode_steps: int | None,
        rows: int | None,
        options: dict[str, object],
    ) -> None:
        if not is_whole_number(processes) or not 1 <= processes <= num_envs:
            raise BadArgument(f"processes is {processes!r}, expected 1 to num_envs, which is {num_envs}")
        if render_mode not in (None, "rgb_array"):
            raise BadArgument(f"render_mode is {render_mode!r}, expected None or 'rgb_array'")
        limit = max_episode_steps
        limit = None if limit is None else whole_number("max_episode_steps", limit, "None or a number from 1", 1)
        self.num_envs, self.render_mode = num_envs, render_mode
        self.autoreset_mode = _autoreset_mode(autoreset_mode)  # TorchRL reads this attribute.
        settings = VectorSettings(self.autoreset_mode, limit, render_mode)
        self._pool = Pool(
            make_options(OWN_ARGUMENTS, **options), settings, num_envs, int(processes), context_of(context), rows
        )
        opened = self._pool.group.opened
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": self.autoreset_mode}
        self.tokenizer: Tokenizer = opened.tokenizer
        self.single_action_space = action_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.single_observation_space = opened.observation_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._has_text = "instruction" in self.single_observation_space.spaces
        self._has_begun = False
        self._over = np.zeros(num_envs, np.bool_)

    def __getstate__(self) -> dict[str, Any]:
        raise CannotCopy("a vector environment cannot be pickled or copied: make another, or copy single environments")

    @property
    def process_ids(self) -> list[int]:
        """Ids of the worker processes, in the order of the episodes that they play."""
        return [worker.process_id for worker in self._pool.workers]

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each segmentation value, by index; empty without that sensor."""
        return self._pool.group.opened.player.labels

    @property
    def factored_labels(self) -> FactoredLabels:
        """The labels as arrays: kind, colour and look of each label, as numbers."""
        return factored(self.labels)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Dict, dict[str, Any]]:
        """Begin episodes, and return the observations and infos of all.

        Args:
            seed: seed of the generator that draws the first environment's episodes, incremented for each further one;
                or one seed for each.
            options: `{"episode": ID}` or `{"episode": [ID, ...]}` selects the episodes, `{"lang": ...}` likewise their
                languages; `{"reset_mask": MASK}`, an array of (num_envs,) bool, begins only some.

        Raises:
            BadArgument: if there is no such episode, or the number of seeds, ids or mask values is wrong.
            gymnasium.error.AlreadyPendingCallError: if only some begin while results are waiting to be received.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        self._check_open("reset")
        keep_texts_in_wrappers()
        calls = episode_starts(self.num_envs, seed, options)
        mask = np.array([call is not None for call in calls])
        if not mask.all():
            self._check_settled("reset")
        self._has_begun = self._has_begun and not mask.all()  # If the reset fails, no episode may continue.
        batch, updates = self._pool.begin(calls)
        self._has_begun = True
        self._over[mask] = False
        return self._observation(batch, self._pool.texts), self._infos(updates.infos)

    def step(self, actions: npt.NDArray[np.int64]) -> VectorStep:
        """Apply one action for each episode, and return observations, rewards, terminated, truncated and infos of all.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended, in the mode DISABLED, or none has begun.
            gymnasium.error.InvalidAction: if an action is not 0 to 3, or the number of actions is wrong.
            gymnasium.error.AlreadyPendingCallError: if results are waiting to be received.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        self._check_open("step")
        self._check_settled("step")
        numbers = check_actions(actions, self.num_envs)
        self._check_begun(slice(None))
        batch, updates = self._pool.step(numbers)
        return self._outcome(batch, self._pool.texts, slice(None), self._infos(updates.infos))

    def heads(self, run_id: str) -> list[bytes]:
        """Return the head of the hash chain over each current episode's actions, 32 bytes (`arramon.v1.chain`)."""
        self._check_open("heads")
        return self._pool.each("heads", run_id)

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a picture of each episode, (height, width, 3) uint8; None unless the mode is "rgb_array".

        Raises:
            gymnasium.error.ResetNeeded: if no episodes have begun.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        self._check_open("render")
        return None if self.render_mode is None else tuple(self._pool.each("pictures"))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Return an attribute of each episode's `members.Member`; if it is callable, the result of calling it.

        Raises:
            AttributeError: if there is no such attribute.
            BadArgument: if a value cannot be passed between processes.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        self._check_open("call")
        return tuple(self._pool.each("call", name, *args, **kwargs))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of each episode, as `call` does."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each episode's `members.Member`; a list or tuple has one value for each.

        Raises:
            BadArgument: if the number of values is not the number of episodes.
            AttributeError: if it cannot be set.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        self._check_open("set_attr")
        each = list(values) if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise BadArgument(f"there are {len(each)} values, expected {self.num_envs}, or one that is no list")
        self._pool.set_attr(name, each)

    def close_extras(self, **_: Any) -> None:
        """End the worker processes, and close all players."""
        self._pool.close()

    def _check_open(self, method: str) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError(
                f"{method}() was called after close(); make another environment"
            )

    def _check_settled(self, method: str) -> None:
        """Check that no results are waiting to be received, so that all episodes can take a step."""

    def _check_begun(self, episodes: Sequence[int] | slice) -> None:
        if not self._has_begun:
            raise gymnasium.error.ResetNeeded("no episodes have begun; call reset() first")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._over[episodes].any():
            raise gymnasium.error.ResetNeeded(
                f"the episodes of {np.flatnonzero(self._over).tolist()} have ended; call reset() with a reset_mask"
            )

    def _outcome(
        self, batch: VectorBatch, texts: Sequence[str], episodes: npt.NDArray[np.int64] | slice, infos: dict[str, Any]
    ) -> VectorStep:
        """Return the result of a step, and record which episodes have ended."""
        # Copies, so that a learner that keeps these small arrays does not keep the images alive.
        rewards, terminated, truncated = batch.rewards.copy(), batch.terminated.copy(), batch.truncated.copy()
        if self.autoreset_mode is AutoresetMode.DISABLED:
            self._over[episodes] = terminated | truncated
        return self._observation(batch, texts), rewards, terminated, truncated, infos

    def _observation(self, batch: VectorBatch, texts: Sequence[str]) -> Dict:
        if not self._has_text:
            return batch.observation
        return {**batch.observation, "instruction": tuple(texts)}

    def _infos(self, by_number: dict[int, dict[str, Any]]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for number in sorted(by_number):
            infos = self._add_info(infos, by_number[number], number)
        return infos


def _autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    if isinstance(mode, AutoresetMode):
        return mode
    try:
        return AutoresetMode(mode)
    except ValueError:
        modes = ", ".join(repr(each.value) for each in AutoresetMode)
        raise BadArgument(f"autoreset_mode is {mode!r}, expected {modes}") from None
