"""What is called with a vector environment: which episodes begin, and how; actions, and of which episodes."""

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
"""Options of a reset that may have a value for each episode."""


def episode_starts(
    count: int, seed: int | Sequence[int | None] | None, options: Mapping[str, Any] | None
) -> list[EpisodeStart | None]:
    """Return the beginning of each of `count` episodes; None for those that the mask leaves as they are.

    Args:
        count: number of the episodes.
        seed: of the first, and the next number for each further; or one for each.
        options: of the reset: `episode` and `lang`, one for all or one for each, and `reset_mask`.

    Raises:
        BadArgument: if seeds, options or mask are not as many as the episodes.
    """
    seeds, mask = _seeds(count, seed), _mask(count, options)
    each: list[dict[str, Any]] = [{} for _ in range(count)]
    for name in PER_EPISODE:
        for index, value in zip(each, _values(count, name, options), strict=True):
            index.update({} if value is None else {name: value})
    return [EpisodeStart(seeds[index], each[index]) if mask[index] else None for index in range(count)]


def check_actions(actions: npt.NDArray[np.int64] | Sequence[int], count: int) -> list[int]:
    """Return `count` actions as numbers.

    Raises:
        gymnasium.error.InvalidAction: if one is none of the four, or there are not so many.
    """
    if np.ndim(actions) == 0:
        raise gymnasium.error.InvalidAction(f"the actions are {actions!r}, expected {count} in an array")
    if len(actions) != count:
        raise gymnasium.error.InvalidAction(f"there are {len(actions)} actions, expected {count}")
    are_numbers = isinstance(actions, np.ndarray) and actions.dtype.kind in "iu"
    return [check_action(action) for action in (actions.tolist() if are_numbers else actions)]  # type: ignore[union-attr]


def episode_numbers(env_id: npt.NDArray[np.int64] | Sequence[int] | None, count: int) -> list[int]:
    """Return the numbers of episodes, of `count` that there are; all of them for None.

    Raises:
        BadArgument: if there is no such episode, or one is named twice.
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
