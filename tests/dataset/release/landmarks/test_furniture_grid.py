"""Distances on the furniture grid of a rebuilt section, and likelihoods of things around walkers."""

import numpy as np
import pytest

from arramon_dataset.release.landmarks.furniture_grid import APART, FEW, apart_from
from arramon_dataset.release.landmarks.kernels import ASIDE, BACK, FRONT, STEP, kernel, likelihood, offsets_in_frames
from arramon_dataset.release.landmarks.mentions import Event
from arramon_server.sim.assets.furniture import footprint_radius

STANDING = [(0.0, 0.0, "bench"), (4.0, -3.0, "cone"), (-2.5, 6.0, "dumpster")]


@pytest.mark.parametrize("count", [1, FEW - 1, FEW, 5 * FEW])
def test_places_leave_room_for_all_that_stands(count: int) -> None:
    places = np.random.default_rng(count).uniform(-8.0, 8.0, (count, 2))
    expected = [
        all(
            np.hypot(x - at, z - along) >= footprint_radius("barrel") + footprint_radius(kind) + APART
            for at, along, kind in STANDING
        )
        for x, z in places
    ]
    assert apart_from(places, "barrel", STANDING).tolist() == expected
    assert apart_from(places, "barrel", []).all()


@pytest.mark.parametrize("side", ["", "left"])
def test_likelihood_is_that_of_the_kernel_and_0_beyond_it(side: str) -> None:
    event = Event(kind="barrel", manner="seen", side=side)
    draws = np.random.default_rng(1)
    origins, directions = draws.uniform(-5.0, 5.0, (6, 2)), draws.uniform(-180.0, 180.0, 6)
    places = np.concatenate([draws.uniform(-40.0, 40.0, (300, 2)), origins + np.array([0.0, 2.0])])
    table, shown = kernel("seen", "", side), likelihood(event, origins, directions, places)
    ahead, right = offsets_in_frames(origins, directions, places)
    rows, columns = np.rint((ahead + BACK) / STEP).astype(int), np.rint((right + ASIDE) / STEP).astype(int)
    for row, column, value in zip(rows.flat, columns.flat, shown.flat, strict=True):
        inside = 0 <= row < table.shape[0] and 0 <= column < table.shape[1]
        assert value == (table[row, column] if inside else 0.0)
    outside = (ahead > FRONT + STEP) | (np.abs(right) > ASIDE + STEP)
    assert outside.any()
    assert (shown > 0.1).any()
