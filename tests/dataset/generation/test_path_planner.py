"""Planned paths: clearance, turns, and reachability of the target."""

import math

import numpy as np
import pytest

from arramon_dataset.generation.clearance_raster import ClearanceRaster
from arramon_dataset.generation.navigation_tasks import follow_actions
from arramon_dataset.generation.path_planner import REACH_FROM, REACH_TO, PathPlanner
from arramon_dataset.layout.solids import Solids
from arramon_server.sim.geometry import Pose
from arramon_server.sim.section import Building, Prop, Section
from tests.dataset.generation.small_section import CROSSING

LETTERS = "FLR"


@pytest.fixture(scope="module")
def walker() -> PathPlanner:
    return PathPlanner(ClearanceRaster.of(CROSSING))


def way(walker: PathPlanner, start: Pose, target: tuple[float, float]) -> str | None:
    actions = walker.actions(start, target, walker.field(*target))
    return None if actions is None else "".join(LETTERS[action] for action in actions)


@pytest.mark.parametrize(
    ("start", "target", "expected"),
    [
        (Pose(0.0, -10.0, 0.0), (0.0, 1.5), "F" * 10),
        (Pose(0.0, 10.0, 180.0), (0.0, -1.5), "F" * 10),
        (Pose(0.0, -10.0, 90.0), (0.0, 1.5), "LLL" + "F" * 10),
        (Pose(0.0, -10.0, 30.0), (0.0, 1.5), "L" + "F" * 10),
    ],
)
def test_straight_paths_are_walked_without_detours(
    walker: PathPlanner, start: Pose, target: tuple[float, float], expected: str
) -> None:
    assert way(walker, start, target) == expected


@pytest.mark.parametrize(("side", "turns"), [(1.0, "RRR"), (-1.0, "LLL")])
def test_corners_are_taken_in_one_quarter_turn(walker: PathPlanner, side: float, turns: str) -> None:
    found = way(walker, Pose(0.0, -11.0, 0.0), (side * 11.5, -1.0))

    assert found is not None
    first, second = found.split(turns)
    assert set(first) == set(second) == {"F"}
    assert 8 <= len(first) <= 13  # Within a unit and a half or so of the crossing's middle.


def test_target_behind_the_start_takes_one_half_turn(walker: PathPlanner) -> None:
    found = way(walker, Pose(0.0, 0.0, 0.0), (0.0, -9.0))

    assert found is not None
    assert found.lstrip("LR") == "F" * (len(found) - 6)
    assert found[:6] in ("L" * 6, "R" * 6)


def test_paths_end_within_reach_and_touch_no_solids(walker: PathPlanner) -> None:
    solids = Solids.of(CROSSING)
    for i, target in enumerate([(2.0, 11.0), (-11.0, 2.0), (11.0, -1.5), (1.5, 7.0), (-2.0, -9.0)]):
        start = Pose(0.5, 1.0, 30.0 * i)
        actions = walker.actions(start, target, walker.field(*target))
        assert actions is not None
        path, end = follow_actions(start, actions)
        right, ahead = end.local(*target)
        assert REACH_FROM <= ahead <= REACH_TO
        assert abs(right) <= 0.5
        places = np.array(path)
        dense = np.concatenate([places[:-1] + share * np.diff(places, axis=0) for share in np.linspace(0, 1, 21)])
        assert solids.distance(dense).min() > 0.26


def test_walled_in_targets_are_unreachable_from_outside() -> None:
    walls = tuple(
        Building(x, z, w, h, 0.0, 2.0, "brick")
        for x, z, w, h in ((0, 4, 3, 0.5), (0, -4, 3, 0.5), (3.5, 0, 0.5, 4.5), (-3.5, 0, 0.5, 4.5))
    )
    walker = PathPlanner(ClearanceRaster.of(Section("8", 0.0, (-10.0, -10.0, 10.0, 10.0), walls, ())))

    assert way(walker, Pose(-7.0, 0.0, 0.0), (0.0, 0.0)) is None
    assert way(walker, Pose(0.0, 2.0, 180.0), (0.0, -1.0)) == "FF"


def test_oblique_streets_are_followed_with_few_turns() -> None:
    angle = 17.0
    sin, cos = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    blocks = tuple(Building(s * 6 * cos, -s * 6 * sin, 3.0, 20.0, angle, 2.0, "brick") for s in (-1, 1))
    walker = PathPlanner(ClearanceRaster.of(Section("8", angle, (-15.0, -25.0, 15.0, 25.0), blocks, ())))

    found = way(walker, Pose(-15 * sin, -15 * cos, 0.0), (15 * sin, 15 * cos))

    assert found is not None
    assert sum(letter != "F" for letter in found) <= 4


def test_paths_go_around_furniture() -> None:
    section = Section(
        "8",
        0.0,
        (-10.0, -12.0, 10.0, 12.0),
        BLOCKS_APART,
        (Prop("phone_booth", 0.0, 0.0, 0.0), Prop("banner", 4, 4, 0)),
    )
    found = way(PathPlanner(ClearanceRaster.of(section)), Pose(0.0, -8.0, 0.0), (0.0, 8.0))

    assert found is not None
    assert {"L", "R"} <= set(found)


BLOCKS_APART = tuple(Building(x, 0.0, 3.0, 12.0, 0.0, 2.0, "brick") for x in (-6.0, 6.0))
