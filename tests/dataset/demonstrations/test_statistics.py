"""Statistics of each episode and combined statistics, against numpy over all data."""

import numpy as np
import pytest

from arramon_dataset.demonstrations.formats.statistics import (
    SAMPLED_FRAMES,
    combined_statistics,
    frame_statistics,
    numeric_statistics,
)


def test_frames() -> None:
    frames = np.random.default_rng(1).integers(10, 200, (SAMPLED_FRAMES, 8, 8, 3), dtype=np.uint8)
    found = frame_statistics(list(frames))
    pixels = frames.reshape(-1, 3) / 255
    for name, expected in (
        ("min", pixels.min(axis=0)),
        ("max", pixels.max(axis=0)),
        ("mean", pixels.mean(axis=0)),
        ("std", pixels.std(axis=0)),
        ("q50", np.quantile(pixels, 0.5, axis=0)),
    ):
        assert np.asarray(found[name]).shape == (3, 1, 1)
        assert np.asarray(found[name]).ravel() == pytest.approx(expected, abs=0.005), name
    assert found["count"] == [SAMPLED_FRAMES]


def test_a_frame_or_two_are_enough() -> None:
    frame = np.full((8, 8, 3), 51, np.uint8)
    found = frame_statistics([frame])
    assert {name: np.ravel(found[name])[0] for name in ("min", "max", "mean", "q01", "q99")} == pytest.approx(
        dict.fromkeys(("min", "max", "mean", "q01", "q99"), 0.2)
    )
    assert np.ravel(found["std"]) == pytest.approx(0.0, abs=1e-6)


def test_all_episodes_together_are_as_one() -> None:
    numbers = np.random.default_rng(2).normal(size=(50, 3))
    found = combined_statistics([numeric_statistics(numbers[:10]), numeric_statistics(numbers[10:])])
    whole = numeric_statistics(numbers)
    for name in ("min", "max", "mean", "std", "count"):
        assert np.asarray(found[name]) == pytest.approx(np.asarray(whole[name])), name
