"""What stands in a person's way."""

import pytest

from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.section import Building, Prop, Section
from arramon_server.web.play.obstacles import find_obstacle

BODIES = city_scene(
    Section(
        "1",
        0.0,
        (-20.0, -20.0, 20.0, 20.0),
        (Building(0.0, 12.0, 5.0, 1.0, 0.0, 3.0, "brick"),),
        (Prop("hydrant", 0.3, 1.0, 0.0, ""), Prop("bench", 8.0, 8.0, 0.0, "")),
    )
).bodies


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        (Pose(0.0, 0.0, 0.0), ("hydrant", "right")),
        (Pose(0.6, 0.0, 0.0), ("hydrant", "left")),
        (Pose(0.3, 0.0, 0.0), ("hydrant", "ahead")),
        (Pose(0.0, 0.0, 180.0), None),
        (Pose(2.0, 10.0, 0.0), ("building//brick", "ahead")),
    ],
)
def test_the_nearest_body_and_its_side(pose: Pose, expected: tuple[str, str] | None) -> None:
    found = find_obstacle(BODIES, pose)
    assert (found and (str(found.label), found.side)) == expected
