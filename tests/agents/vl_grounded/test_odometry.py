"""Odometry features by dead reckoning from actions."""

import numpy as np
import pytest

from arramon_agents.vl_grounded.odometry import ODOMETRY_SIZE, odometry
from arramon_client.world import HEADINGS


@pytest.mark.parametrize(
    ("actions", "heading", "expected"),
    [
        ([], 0, [0, 0, 0, 0, 0, 0, 0]),
        ([0, 0], 0, [0, -0.2, 0.1, 0.2, 0, 2 / 30, 2 / 50]),
        ([0, 0, 2, 2, 2], 3, [0.2, 0, 0.1, 0, 0.5, 2 / 30, 5 / 50]),  # The start is to the right.
        ([1], 11, [0, 0, 0, 0, -1 / 6, 0, 1 / 50]),
        ([2] * 6 + [0], 6, [0, -0.1, 0.05, 0.1, 0, 1 / 30, 7 / 50]),
    ],
)
def test_after(actions: list[int], heading: int, expected: list[float]) -> None:
    rows = odometry(actions)
    assert rows.shape == (len(actions) + 1, ODOMETRY_SIZE)
    assert rows[-1, :HEADINGS].argmax() == heading
    assert rows[-1, :HEADINGS].sum() == 1
    np.testing.assert_allclose(rows[-1, HEADINGS:], expected, atol=1e-6)
