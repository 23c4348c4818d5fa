"""Zebra crossings: across streets that leave a junction of three or more, never across alleys."""

import math
from itertools import combinations
from random import Random

import pytest

from arramon_dataset.plans import plan_ids, read_plan
from arramon_dataset.plans.junction_detection import detect_junctions, middle_lines_of
from arramon_dataset.plans.zebras import APART, zebra_crossings


@pytest.mark.parametrize("section_id", plan_ids())
def test_they_lie_on_the_middle_lines_of_streets(section_id: str) -> None:
    plan = read_plan(section_id)
    zebras = zebra_crossings(plan, Random(1))
    assert len(zebras) >= 4
    lines = middle_lines_of(plan)
    for zebra in zebras:
        nearest = min(
            (math.dist((zebra.x, zebra.z), place), line.number) for line in lines for place in line.places.tolist()
        )
        assert nearest[0] < 0.3
        assert plan.streets[nearest[1]].width >= 4.0
    assert all(math.dist((a.x, a.z), (b.x, b.z)) > APART for a, b in combinations(zebras, 2))


def test_another_draw_gives_others_and_the_same_the_same() -> None:
    plan = read_plan("4")
    assert zebra_crossings(plan, Random(1)) == zebra_crossings(plan, Random(1)) != zebra_crossings(plan, Random(2))


def test_a_crossing_has_four_ways_out() -> None:
    plan = read_plan("3")
    lines = middle_lines_of(plan)
    counts = [len(meeting.mouths) for meeting in detect_junctions(plan, lines)]
    assert max(counts) == 4
    assert counts.count(1) == 2
