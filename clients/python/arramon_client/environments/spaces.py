"""Spaces of observations and actions, and observations as Gymnasium has them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from arramon_client.agent import Action, Observation
from arramon_client.environments.backend import PHASES, Settings, SplitInfo
from arramon_client.environments.tokens import Tokenizer

NO_ACTION = len(Action)
"""`last_action` before the first step."""

FARTHEST_DEPTH = 65.535
"""Greatest depth, in units."""

WIDEST = 10_000.0
"""Bound of positions, in units: far beyond every section."""

Dict = dict[str, Any]
"""An observation."""


def action_space() -> "spaces.Discrete":
    """Return a new space of actions, numbered as in the release."""
    return spaces.Discrete(len(Action))


def observation_space(settings: Settings, split: SplitInfo, tokenizer: Tokenizer) -> "spaces.Dict":
    """Return a new space of observations, as `docs/environments.md` describes it."""
    size = settings.image_size
    texts = split.texts[settings.language]
    sensors: dict[str, Callable[[], spaces.Space[Any]]] = {
        "rgb": lambda: spaces.Box(0, 255, (size, size, 3), np.uint8),
        "depth": lambda: spaces.Box(0.0, FARTHEST_DEPTH, (size, size), np.float32),
        "segmentation": lambda: spaces.Box(0, 65535, (size, size), np.uint16),
        "pose": lambda: spaces.Box(
            np.array((-WIDEST, -WIDEST, 0.0)), np.array((WIDEST, WIDEST, 360.0)), dtype=np.float64
        ),
    }
    return spaces.Dict({
        **{name: sensors[name]() for name in settings.sensors},
        "instruction": spaces.Text(texts.longest, min_length=1, charset=texts.alphabet),
        "instruction_tokens": spaces.Box(0, tokenizer.size - 1, (tokenizer.length,), np.int32),
        "turn": spaces.Discrete(2, start=1),
        "phase": spaces.Discrete(len(PHASES)),
        "steps_left": spaces.Box(0, split.steps_per_phase, (1,), np.int32),
        "last_action": spaces.Discrete(len(Action) + 1),
    })  # fmt: skip


@dataclass
class Translator:
    """Turns the client's observations into those of the space.

    Args:
        tokenizer: of the instructions.
    """

    tokenizer: Tokenizer
    _encode: Callable[[str], npt.NDArray[np.int32]] = field(init=False)

    def __post_init__(self) -> None:
        self._encode = lru_cache(64)(self.tokenizer.encode)

    def tokens(self, text: str) -> npt.NDArray[np.int32]:
        """Return the numbers of a text, not to be changed: the same array is returned again."""
        return self._encode(text)

    def observation(self, seen: Observation, last_action: int) -> Dict:
        """Return the observation; its images are those of `seen`."""
        values: Dict = {}
        if seen.rgb is not None:
            values["rgb"] = seen.rgb
        if seen.depth is not None:
            values["depth"] = seen.depth
        if seen.segmentation is not None:
            values["segmentation"] = seen.segmentation
        if seen.pose is not None:
            values["pose"] = np.array(seen.pose)
        values["instruction"] = seen.instruction
        values["instruction_tokens"] = self._encode(seen.instruction).copy()
        values["turn"] = np.int64(seen.turn)
        values["phase"] = np.int64(PHASES.index(seen.phase))
        values["steps_left"] = np.array((seen.steps_left,), np.int32)
        values["last_action"] = np.int64(last_action)
        return values
