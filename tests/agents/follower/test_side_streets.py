"""The middle of a side street."""

import numpy as np
import pytest

from arramon_agents.follower.side_streets import find_middle
from arramon_agents.mapping.ground_map import GroundMap


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("width", [4.0, 6.0])
def test_the_middle_of_a_side_street_has_the_most_room(side: int, width: float) -> None:
    ground = GroundMap()
    for out in np.arange(2.5, 9.0, 0.25):
        ground.block(side * float(out), 5.0)
        ground.block(side * float(out), 5.0 + width)
    x, z = find_middle(ground, (0.0, 6.2), 0.0, side)
    assert x == pytest.approx(0.0)
    assert z == pytest.approx(5.0 + width / 2, abs=0.6)


def test_the_place_is_kept_where_nothing_is_known() -> None:
    assert find_middle(GroundMap(), (1.0, 6.0), 0.0, 1) == (1.0, 6.0)
