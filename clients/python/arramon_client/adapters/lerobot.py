"""An environment by the protocol of LeRobot's EnvHub: `make_env`, `is_success`, `task_description`, `pixels`.

LeRobot itself is not needed. The actions of its policies are vectors: the largest of four numbers is the action.
"""

import os
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv

from arramon_client.adapters.host import Host
from arramon_client.environments.single import ArraMonEnv
from arramon_client.errors import UsageError
from arramon_client.world import PHASES, TURNS, Action

SUITE = "arramon"
"""Name of the only suite of `make_env`, which has one task, 0."""

Observation = dict[str, Any]


class LeRobotEnv(gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """One environment; an episode on a host is a run of its own.

    The observation has `pixels`, (size, size, 3) uint8, and `agent_pos`, the pose (x, z, heading in degrees), (3,)
    float32. `info["is_success"]` is whether both objects were put into their cells (PTC gated by CTC-3 is 1), known at
    the episode's end; `info` then has `cause`, `scores` and, on a host, `run_id`.

    Args:
        lang: language of the instructions.
        split: name of the split; a hidden one does not disclose success.
        server: address of a host, HOST:PORT; None to play in this process.
        image_size: side length of images in pixels.
        options: further options of `arramon_client.environments`, such as `data`.

    Raises:
        UsageError: if the split is hidden.
        BadArgument: if another argument is wrong.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 - Gymnasium's interface
    render_mode = "rgb_array"
    task = SUITE

    def __init__(
        self,
        lang: str = "en",
        split: str = "val_seen",
        server: str | None = None,
        image_size: int = 224,
        **options: Any,
    ) -> None:
        # On a host episodes are named, so that each has a run of its own, whose scores are known at its end.
        self._ids = [] if server is None else _episode_ids(lang, split, server)
        self._env = ArraMonEnv(
            lang=lang, split=split, server=server, image_size=image_size, sensors=("rgb", "pose"), **options
        )
        self._number = 0
        self.action_space = spaces.Box(0.0, 1.0, (len(Action),), np.float32)
        self.observation_space = spaces.Dict({
            "pixels": spaces.Box(0, 255, (image_size, image_size, 3), np.uint8),
            "agent_pos": spaces.Box(-np.inf, np.inf, (3,), np.float32),
        })  # fmt: skip
        self._max_episode_steps = TURNS * len(PHASES) * self._env.player.split.steps_per_phase
        self._pixels: npt.NDArray[np.uint8] | None = None

    @property
    def task_description(self) -> str:
        """The current instruction; it changes with the phases of an episode."""
        return self._env.task_description

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: draws the episode; without it they come in order on a host, and at random in this process.
            options: `{"episode": ID}` selects the episode.
        """
        super().reset(seed=seed)
        if self._ids and not (options or {}).get("episode"):
            number, self._number = (self._number, self._number + 1) if seed is None else (seed, self._number)
            options = {**(options or {}), "episode": self._ids[number % len(self._ids)]}
        observation, info = self._env.reset(seed=seed, options=options)
        return self._converted(observation), {**info, "is_success": False}

    def step(self, action: npt.NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Apply the action with the largest of four numbers.

        Raises:
            UsageError: if the action does not have four numbers.
        """
        if np.shape(action) != (len(Action),):
            raise UsageError(f"the action has the shape {np.shape(action)}, expected ({len(Action)},)")
        observation, reward, terminated, truncated, info = self._env.step(int(np.argmax(action)))
        info["is_success"] = False
        if terminated:
            info["is_success"] = info["scores"]["total"]["PTC@CTC-3"] == 1.0
            run = getattr(self._env.player, "run", None)
            info |= {} if run is None else {"run_id": run.run_id}
        return self._converted(observation), reward, terminated, truncated, info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return what the agent sees, (size, size, 3) uint8; None before the first episode."""
        return self._pixels

    def close(self) -> None:
        """Release all resources; on a host, end the run."""
        self._env.close()

    def _converted(self, observation: dict[str, Any]) -> Observation:
        self._pixels = observation["rgb"]
        return {"pixels": observation["rgb"], "agent_pos": observation["pose"].astype(np.float32)}


def _episode_ids(language: str, split: str, server: str) -> list[str]:
    host = Host(language=language, split=split, agent=SUITE, server=server)
    try:
        return list(host.episodes())
    finally:
        host.close()


def make_env(
    n_envs: int = 1, use_async_envs: bool = False, cfg: object = None
) -> dict[str, dict[int, VectorEnv[Any, Any, Any]]]:
    """Return vector environments as EnvHub expects them: `{suite: {task: environment}}`.

    What is played is chosen by `ARRAMON_LANGUAGE` ("en"), `ARRAMON_SPLIT` ("val_seen"), `ARRAMON_SERVER` (HOST:PORT;
    without it in this process, with the data folder `ARRAMON_DATA`) and `ARRAMON_IMAGE_SIZE` (224).

    Args:
        n_envs: number of environments.
        use_async_envs: whether each has a process of its own.
        cfg: an `EnvConfig` of LeRobot, which has nothing that is needed here.
    """
    del cfg
    vector = AsyncVectorEnv if use_async_envs else SyncVectorEnv
    makers: list[Callable[[], LeRobotEnv]] = [_make_one] * n_envs
    return {SUITE: {0: vector(makers, autoreset_mode=AutoresetMode.SAME_STEP)}}


def _make_one() -> LeRobotEnv:
    given = os.environ.get
    return LeRobotEnv(
        lang=given("ARRAMON_LANGUAGE", "en"),
        split=given("ARRAMON_SPLIT", "val_seen"),
        server=given("ARRAMON_SERVER"),
        image_size=int(given("ARRAMON_IMAGE_SIZE", "224")),
    )
