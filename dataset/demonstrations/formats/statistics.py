"""Feature statistics as in LeRobot: extremes, mean, deviation and quantiles, of each episode and of all."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Statistics = dict[str, list[Any]]
"""Values by name: "min", "max", "mean", "std", "count", "q01" and so on."""

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}

SAMPLED_FRAMES = 16
"""Number of evenly spaced frames of an episode that are used for statistics."""


def numeric_statistics(values: npt.NDArray[Any]) -> Statistics:
    """Return the statistics of a feature over the steps of an episode.

    Args:
        values: (steps, length).
    """
    numbers = values.astype(np.float64)
    return {
        "min": numbers.min(axis=0).tolist(),
        "max": numbers.max(axis=0).tolist(),
        "mean": numbers.mean(axis=0).tolist(),
        "std": numbers.std(axis=0).tolist(),
        "count": [len(numbers)],
        **{name: np.quantile(numbers, share, axis=0).tolist() for name, share in QUANTILES.items()},
    }


def frame_statistics(frames: Sequence[npt.NDArray[np.uint8]]) -> Statistics:
    """Return the statistics of the channels of sampled frames of an episode, scaled to 0 to 1, (3, 1, 1) each.

    Args:
        frames: (size, size, 3) uint8 each.
    """
    chosen = np.unique(np.linspace(0, len(frames) - 1, SAMPLED_FRAMES).round().astype(int))
    channels = np.stack([frames[i] for i in chosen]).reshape(-1, 3)
    counts = np.stack([np.bincount(channels[:, channel], minlength=256) for channel in range(3)]).astype(np.float64)
    shares = counts / counts.sum(axis=1, keepdims=True)
    levels = np.arange(256) / 255.0
    mean = shares @ levels
    below = shares.cumsum(axis=1)
    there = counts > 0
    values = {
        "min": levels[there.argmax(axis=1)],
        "max": levels[255 - there[:, ::-1].argmax(axis=1)],
        "mean": mean,
        "std": np.sqrt(np.maximum(shares @ levels**2 - mean**2, 0.0)),
        **{name: levels[(below >= share).argmax(axis=1)] for name, share in QUANTILES.items()},
    }
    return {**{name: value.reshape(3, 1, 1).tolist() for name, value in values.items()}, "count": [len(chosen)]}


def combined_statistics(episodes: Sequence[Mapping[str, Any]]) -> Statistics:
    """Combine the statistics of several episodes; quantiles are weighted means, as in LeRobot."""
    values = {name: np.stack([np.asarray(one[name], np.float64) for one in episodes]) for name in episodes[0]}
    counts = values["count"].reshape(-1, *(1 for _ in values["mean"].shape[1:]))
    total = counts.sum()
    mean = (values["mean"] * counts).sum(axis=0) / total
    variance = ((values["std"] ** 2 + (values["mean"] - mean) ** 2) * counts).sum(axis=0) / total
    return {
        "min": values["min"].min(axis=0).tolist(),
        "max": values["max"].max(axis=0).tolist(),
        "mean": mean.tolist(),
        "std": np.sqrt(variance).tolist(),
        "count": [int(total)],
        **{name: ((values[name] * counts).sum(axis=0) / total).tolist() for name in QUANTILES},
    }
