"""Observation and action spaces, and the conversion of observations to those spaces."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from arramon_client.agent import Action, Observation
from arramon_client.environments.backend import PlayerSettings, TextBounds
from arramon_client.environments.tokens import Tokenizer
from arramon_client.world import IMAGE_SENSORS, PHASES

NO_ACTION = len(Action)
"""Value of `last_action` before the first step."""

OBSERVED_SENSORS = (*IMAGE_SENSORS, "pose")
"""Sensors of the environments, in the order of the observation's keys."""

KEYS = (*OBSERVED_SENSORS, "instruction", "instruction_tokens", "turn", "phase", "steps_left", "last_action")
"""Keys of an observation, in order."""

TURN_NUMBERS = 3
"""Size of the space of turns, which are numbered 1 and 2; 0 never occurs. `Discrete(2, start=1)` would be equivalent,
but libraries that one-hot encode it ignore its start, and fail at turn 2."""

MAX_LABEL = 32767
"""Largest label index. The space of segmentations is int16, unlike an agent's uint16, which TorchRL does not support;
there are only a few hundred labels."""

MAX_DEPTH = 65.535
"""Largest depth, in units."""

MAX_POSITION = 10_000.0
"""Bound of coordinates, in units, far larger than any section."""

Dict = dict[str, Any]
"""An observation."""


def action_space() -> "spaces.Discrete":
    """Return a new action space, with actions numbered as in the official release."""
    return spaces.Discrete(len(Action))


def merge_bounds(texts: Iterable[TextBounds]) -> TextBounds:
    """Return the union of alphabets and the maximum lengths of texts in several languages."""
    all_texts = list(texts)
    return TextBounds(
        alphabet="".join(sorted(set().union(*(each.alphabet for each in all_texts)))),
        longest=max(each.longest for each in all_texts),
        longest_utf8=max(each.longest_utf8 for each in all_texts),
    )


def observation_space(
    settings: PlayerSettings,
    texts: TextBounds,
    steps_per_phase: int,
    tokenizer: Tokenizer,
    keys: Sequence[str] | None = None,
) -> "spaces.Dict":
    """Return a new observation space, as described in `docs/reference/environments.md`.

    Args:
        settings: settings of the player.
        texts: alphabet and lengths of the instructions.
        steps_per_phase: step limit of a phase.
        tokenizer: tokenizer of the instructions.
        keys: keys of the observation; None for all.
    """
    size = settings.image_size
    made: dict[str, Callable[[], spaces.Space[Any]]] = {
        "rgb": lambda: spaces.Box(0, 255, (size, size, 3), np.uint8),
        "depth": lambda: spaces.Box(0.0, MAX_DEPTH, (size, size), np.float32),
        "segmentation": lambda: spaces.Box(0, MAX_LABEL, (size, size), np.int16),
        "pose": lambda: spaces.Box(
            np.array((-MAX_POSITION, -MAX_POSITION, 0.0)),
            np.array((MAX_POSITION, MAX_POSITION, 360.0)),
            dtype=np.float64,
        ),
        "instruction": lambda: spaces.Text(texts.longest, min_length=1, charset=texts.alphabet),
        "instruction_tokens": lambda: spaces.Box(0, tokenizer.size - 1, (tokenizer.length,), np.int32),
        "turn": lambda: spaces.Discrete(TURN_NUMBERS),
        "phase": lambda: spaces.Discrete(len(PHASES)),
        "steps_left": lambda: spaces.Box(0, steps_per_phase, (1,), np.int32),
        "last_action": lambda: spaces.Discrete(len(Action) + 1),
    }
    available = (key for key in KEYS if key not in OBSERVED_SENSORS or key in settings.sensors)
    return spaces.Dict({key: made[key]() for key in available if keys is None or key in keys})


@dataclass
class ObservationConverter:
    """Converts the client's observations to observations of the Gymnasium space.

    Args:
        tokenizer: tokenizer of the instructions.
        keys: keys of the observation; None for all.
    """

    tokenizer: Tokenizer
    keys: Sequence[str] | None = None
    _encode: Callable[[str], npt.NDArray[np.int32]] = field(init=False)

    def __post_init__(self) -> None:
        self._encode = lru_cache(64)(self.tokenizer.encode)

    def tokens(self, text: str) -> npt.NDArray[np.int32]:
        """Return the tokens of a text; the array is cached and must not be modified."""
        return self._encode(text)

    def observation(self, seen: Observation, last_action: int) -> Dict:
        """Return the observation with the chosen keys; its images are not copied."""
        return self.select_keys(self.full_observation(seen, last_action))

    def select_keys(self, full: Dict) -> Dict:
        """Return the chosen keys of an observation."""
        return full if self.keys is None else {key: value for key, value in full.items() if key in self.keys}

    def full_observation(self, seen: Observation, last_action: int) -> Dict:
        """Return the observation with all keys, as for rendering; its images are not copied."""
        values: Dict = {}
        if seen.rgb is not None:
            values["rgb"] = seen.rgb
        if seen.depth is not None:
            values["depth"] = seen.depth
        if seen.segmentation is not None:
            values["segmentation"] = seen.segmentation.view(np.int16)
        if seen.pose is not None:
            values["pose"] = np.array(seen.pose)
        values["instruction"] = seen.instruction
        values["instruction_tokens"] = self._encode(seen.instruction).copy()
        values["turn"] = np.int64(seen.turn)
        values["phase"] = np.int64(PHASES.index(seen.phase))
        values["steps_left"] = np.array((seen.steps_left,), np.int32)
        values["last_action"] = np.int64(last_action)
        return values
