"""Sections built from plans: every street can be walked, and nobody gets out."""

from functools import cache

import numpy as np
import pytest

from server.episodes.plans import build_section, free_points, plan_ids, read_plan
from server.sim.section import Section


@cache
def built(section_id: str) -> Section:
    return build_section(read_plan(section_id), "arramon")


@pytest.mark.parametrize("section_id", plan_ids())
def test_all_streets_are_one_piece_of_free_ground(section_id: str) -> None:
    free = free_points(built(section_id), 0.25)
    for line in read_plan(section_id).lines():
        middle = (line[:-1] + line[1:]) / 2
        for point in middle:
            assert np.hypot(*(free - point).T).min() < 0.3
