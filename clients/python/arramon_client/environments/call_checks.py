"""Validation of a vector environment's calls: seeds, reset options, actions and episode numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from arramon_client.environments.arguments import check_seed, is_whole_number, whole_number
from arramon_client.environments.episodes import check_action
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.group import EpisodeStart

PER_EPISODE = ("episode", "lang")
"""Reset options that accept one value for all episodes, or one for each."""


def episode_starts(
    count: int, seed: int | Sequence[int | None] | None, options: Mapping[str, Any] | None
) -> list[EpisodeStart | None]:
    """Return how each of `count` episodes begins; None for those that the reset mask leaves out.

    Args:
        count: number of episodes.
        seed: seed of the first episode, incremented for each further one; or one seed for each.
        options: options of the reset: `episode` and `lang`, one for all or one for each, and `reset_mask`.

    Raises:
        BadArgument: if the number of seeds, options or mask values is not the number of episodes.
    """
    seeds, mask = _seeds(count, seed), _mask(count, options)
    each: list[dict[str, Any]] = [{} for _ in range(count)]
    for name in PER_EPISODE:
        for own, value in zip(each, _values(count, name, options), strict=True):
            own.update({} if value is None else {name: value})
    return [EpisodeStart(seeds[index], each[index]) if mask[index] else None for index in range(count)]


def check_actions(actions: npt.NDArray[np.int64] | Sequence[int], count: int) -> list[int]:
    """Return the actions as ints, after checking that there are `count` valid ones.

    Raises:
        gymnasium.error.InvalidAction: if their number is different, or one is not 0 to 3.
    """
    if np.ndim(actions) == 0:
        raise gymnasium.error.InvalidAction(f"the actions are {actions!r}, expected {count} in an array")
    if len(actions) != count:
        raise gymnasium.error.InvalidAction(f"there are {len(actions)} actions, expected {count}")
    are_numbers = isinstance(actions, np.ndarray) and actions.dtype.kind in "iu"
    return [check_action(action) for action in (actions.tolist() if are_numbers else actions)]  # type: ignore[union-attr]


def episode_numbers(env_id: npt.NDArray[np.int64] | Sequence[int] | None, count: int) -> list[int]:
    """Return the episode numbers in `env_id`, each below `count`; all of them for None.

    Raises:
        BadArgument: if there is no such episode, or one is repeated.
    """
    if env_id is None:
        return list(range(count))
    if np.ndim(env_id) != 1:
        raise BadArgument(f"env_id is {env_id!r}, expected numbers of episodes in an array, or None for all")
    are_numbers = isinstance(env_id, np.ndarray) and env_id.dtype.kind in "iu"
    numbers = env_id.tolist() if are_numbers else list(env_id)  # type: ignore[union-attr]
    for number in numbers:
        if not (type(number) is int or is_whole_number(number)) or not 0 <= number < count:
            raise BadArgument(f"there is no episode {number!r} in env_id; there are 0 to {count - 1}")
    if len(set(numbers)) < len(numbers):
        raise BadArgument(f"env_id is {env_id!r}, expected each episode once")
    return [int(number) for number in numbers]


def _seeds(count: int, seed: int | Sequence[int | None] | None) -> list[int | None]:
    if seed is None:
        return [None] * count
    if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
        if len(seed) != count:
            raise BadArgument(f"there are {len(seed)} seeds, expected {count}")
        return [check_seed(each) for each in seed]
    first = whole_number("seed", seed, "None, a whole number from 0, or one for each episode", 0)
    return [first + number for number in range(count)]


def _mask(count: int, options: Mapping[str, Any] | None) -> list[bool]:
    mask = (options or {}).get("reset_mask")
    if mask is None:
        return [True] * count
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (count,):
        raise BadArgument(f"reset_mask is {mask!r}, expected an array of bool with the shape ({count},)")
    if not mask.any():
        raise BadArgument("reset_mask is False everywhere, expected at least one episode to begin")
    return [bool(each) for each in mask]


def _values(count: int, name: str, options: Mapping[str, Any] | None) -> list[Any]:
    value = (options or {}).get(name)
    if np.ndim(value) == 0:  # type: ignore[arg-type]
        return [value] * count
    if len(value) != count:  # type: ignore[arg-type]
        raise BadArgument(f"there are {len(value)} {name}s, expected {count}")  # type: ignore[arg-type]
    return list(value)  # type: ignore[arg-type]
