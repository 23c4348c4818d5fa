"""Features for small policies in the assembly room, and evaluation of a policy; for `ppo_room` and `imitate_room`."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

import arramon_client.environments  # noqa: F401 - registers the environments
from arramon_client.agent import Observation
from arramon_client.environments.labels import factored
from arramon_client.words import words

Vector = npt.NDArray[np.float32]

EVALUATED = 100
"""Number of tasks of an evaluation; each has two turns."""

VOCABULARY = words(
    "in on front behind left right top between next beside near to of the wall and it one far corner middle back "
    "wooden wood brick spotted striped dotted second first other above under end side opposite"
)
"""Words whose presence in the instruction is a feature, in addition to the objects that it names."""

COLUMNS, ROWS, HEADINGS = 5, 4, 12
GRID = 8
"""The view is divided into GRID x GRID fields."""

SENSORS, SIZE = ("segmentation", "pose"), 32
"""The observed keys, and the side length of the view in pixels."""


class Features(gymnasium.ObservationWrapper[Vector, np.int64, dict[str, Any]]):
    """Feature vector for a small policy: cell, heading, turn, words, and where the named objects are in view.

    For each field of the view: the share of it that shows things of a kind, of a colour and of a pattern that the
    instruction names, and of all three at once.
    """

    def __init__(self, env: gymnasium.Env[dict[str, Any], np.int64]) -> None:
        super().__init__(env)
        labels = env.get_wrapper_attr("labels")
        self._labels = factored(labels)
        self._things = np.array([label.look in ("dotted", "striped") and label.colour != "" for label in labels])
        self._text = ""  # The latest instruction, and what is known of it.
        self._known = np.zeros(len(VOCABULARY), np.float32)
        self._named = np.zeros((4, len(labels)), np.float32)
        size = COLUMNS * ROWS + HEADINGS + 1 + len(VOCABULARY) + 4 * GRID * GRID
        self.observation_space = gymnasium.spaces.Box(0.0, 1.0, (size,), np.float32)

    def observation(self, observation: dict[str, Any]) -> Vector:
        """Return the features, (features,) float32 from 0 to 1."""
        if observation["instruction"] != self._text:
            self._text = observation["instruction"]
            said = set(words(self._text))
            self._known = np.array([word in said for word in VOCABULARY], np.float32)
            self._named = self._by_label(said)
        column, row, heading = observation["pose"]
        cells, facing = np.zeros(COLUMNS * ROWS, np.float32), np.zeros(HEADINGS, np.float32)
        cells[int(column) * ROWS + int(row)] = 1.0
        facing[round(heading / 30.0) % HEADINGS] = 1.0
        seen = self._named[:, observation["segmentation"]]
        side = seen.shape[-1] // GRID
        fields = seen.reshape(4, GRID, side, GRID, side).sum(axis=4).sum(axis=2) / side**2
        second = np.array([observation["turn"] - 1], np.float32)
        return np.concatenate([cells, facing, second, self._known, fields.ravel()])

    def demonstrated(self, seen: Observation) -> Vector:
        """Return the features of an observation from a demonstration."""
        return self.observation({name: getattr(seen, name) for name in ("instruction", "pose", "segmentation", "turn")})

    def _by_label(self, said: set[str]) -> Vector:
        """Return whether each label's kind, colour, pattern, and all three are named, (4, labels)."""
        labels = self._labels
        parts = ((labels.kinds, labels.kind), (labels.colours, labels.colour), (labels.looks, labels.look))
        named = np.stack([np.array([name in said for name in names])[numbers] for names, numbers in parts])
        named = np.concatenate((named, named.all(axis=0, keepdims=True)))
        found: Vector = (named & self._things).astype(np.float32)
        return found


def make(data: str | None, **options: object) -> Callable[[], Features]:
    """Return a function that makes an environment with a data folder's tasks, or with randomly drawn ones."""
    given: dict[str, Any] = {
        "sensors": SENSORS,
        "image_size": SIZE,
        "reward": "progress",
        "steps_per_phase": 40,
        **options,
    }
    return lambda: Features(gymnasium.make("arramon/ArraMonRoom-v0", data=data, **given))


def placed(choose: Callable[[Vector], int], tasks: int = EVALUATED) -> float:
    """Return the mean PTC of a policy over the first randomly drawn tasks.

    Args:
        choose: returns the policy's action for the features of an observation.
        tasks: how many.
    """
    env, found = make(None)(), []
    for task in range(tasks):
        features, _ = env.reset(options={"episode": f"room-{task}"})
        terminated = False
        while not terminated:
            features, _, terminated, _, info = env.step(np.int64(choose(features)))
        found.append(info["scores"]["total"]["PTC"])
    env.close()
    return float(np.mean(found))
