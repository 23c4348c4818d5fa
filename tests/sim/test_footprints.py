"""Exact collision checks on the plane: distances, the index of bodies, variations, unfit colliders."""

import math
from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_client.world import AGENT_RADIUS, FURNITURE
from arramon_server.sim.assets.furniture import COLOURS, IMPORTED_COLOURS, piece_of
from arramon_server.sim.city import city_scene
from arramon_server.sim.footprints import Footprint, Footprints, Place
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.scene import Body, BoxCollider, Scene
from tests.dataset.plans.sections import ALL, section_of

BOX = BoxCollider(2.0, 0.5, 2.0)


def body(x: float, y: float, heading: float = 0.0, collider: BoxCollider | None = BOX, name: str = "box") -> Body:
    return Body(name, "box", "grey", (x, y, 0.0), heading, collider=collider)


def scene(*bodies: Body) -> Scene:
    return Scene("test", bodies, {}, {})


@pytest.mark.parametrize(
    ("start", "end", "heading", "distance"),
    [
        ((0.0, -3.0), (0.0, -2.0), 0.0, 1.5),  # towards a side
        ((-5.0, 2.0), (5.0, 2.0), 0.0, 1.5),  # along it
        ((5.0, 4.5), (6.0, 9.0), 0.0, 5.0),  # an end from a corner
        ((2.0, 2.5), (4.0, 0.5), 0.0, math.sqrt(2.0)),  # a corner from the middle of the way
        ((0.0, -3.0), (0.0, 3.0), 0.0, 0.0),  # across
        ((-9.0, -1.0), (9.0, 1.0), 0.0, 0.0),  # from side to side, both ends outside
        ((1.5, 1.0), (2.5, 0.0), 0.0, 0.0),  # through a corner
        ((0.1, 0.1), (0.2, 0.2), 0.0, 0.0),  # inside
        ((2.0, 0.5), (2.0, 0.5), 0.0, 0.0),  # on a corner
        ((0.0, 3.0), (0.0, 3.0), 0.0, 2.5),  # no way at all
        ((0.0, -3.0), (0.0, -2.5), 90.0, 0.5),  # turned: its long axis points along Y
        ((3.0, 0.0), (2.0, 0.0), 90.0, 1.5),
        (
            (0.0, 1.0),
            (3.0, 1.0),
            45.0,
            math.sqrt(0.5) - 0.5,
        ),  # its long axis points to the lower right
        ((0.0, -1.0), (-3.0, -1.0), 45.0, math.sqrt(0.5) - 0.5),
    ],
)
def test_distances_of_segments_from_a_rectangle(start: Place, end: Place, heading: float, distance: float) -> None:
    for one, other in ((start, end), (end, start)):
        assert Footprint.of(body(0.0, 0.0, heading)).distance(one, other) == pytest.approx(distance, abs=1e-12)


coordinates = st.floats(-4.0, 4.0)
places = st.tuples(coordinates, coordinates)


def nearest(box: Body, start: Place, end: Place) -> float:
    """The distance by search along the way: the distance of a point from a convex shape is convex along a line."""
    collider = box.collider
    assert collider is not None
    turn = math.radians(box.heading)

    def at(share: float) -> float:
        x, y = (start[i] + share * (end[i] - start[i]) - box.position[i] for i in (0, 1))
        across = max(abs(x * math.cos(turn) - y * math.sin(turn)) - collider.half_width, 0.0)
        along = max(abs(x * math.sin(turn) + y * math.cos(turn)) - collider.half_length, 0.0)
        return math.hypot(across, along)

    low, high = 0.0, 1.0
    for _ in range(100):
        one, other = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, other) if at(one) <= at(other) else (one, high)
    return min(at(low), at(0.0), at(1.0))


@settings(max_examples=400, deadline=None)
@given(places, places, places, st.floats(0.0, 360.0), st.floats(0.01, 3.0), st.floats(0.01, 3.0))
def test_distances_agree_with_a_search_along_the_way(
    start: Place, end: Place, at: Place, heading: float, width: float, length: float
) -> None:
    box = body(*at, heading, BoxCollider(width, length, 1.0))
    assert Footprint.of(box).distance(start, end) == pytest.approx(nearest(box, start, end), abs=1e-7)


def any_touched(bodies: Iterable[Body], start: Place, end: Place) -> bool:
    return any(Footprint.of(body).distance(start, end) <= AGENT_RADIUS for body in bodies if body.collider is not None)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(0, 360)), max_size=12),
    st.tuples(st.floats(-40, 40), st.floats(-40, 40)),
    st.floats(0, 360),
    st.sampled_from([0.0, 1.0, 7.0, 1e6]),
)
def test_no_body_is_missed_by_the_index(
    poses: list[tuple[float, float, float]], start: Place, heading: float, length: float
) -> None:
    bodies = [body(x, y, turn, name=str(i)) for i, (x, y, turn) in enumerate(poses)]
    angle = math.radians(heading)
    end = start[0] + length * math.sin(angle), start[1] + length * math.cos(angle)
    free = not any_touched(bodies, start, end)
    assert Footprints(scene(*bodies)).way_is_free(start, end) is free
    half = len(bodies) // 2
    grounds = Footprints(scene(*bodies[:half]))
    assert grounds.way_is_free(start, end, added=bodies[half:]) is free
    assert Footprints(scene(*bodies)).way_is_free(start, end, removed=frozenset(bodies), added=bodies) is free
    assert Footprints(scene(*bodies)).way_is_free(start, end, removed=frozenset(bodies))


def test_touching_is_no_free_way() -> None:
    ground = Footprints(scene(body(0.0, 0.0)))
    edge = -0.5 - AGENT_RADIUS
    assert not ground.way_is_free((0.0, edge - 1.0), (0.0, edge))
    assert ground.way_is_free((0.0, edge - 1.0), (0.0, edge - 1e-12))


def test_bodies_without_a_collider_block_nothing() -> None:
    assert Footprints(scene(body(0.0, 0.0, collider=None))).way_is_free((0.0, 0.0), (0.0, 1.0))


@pytest.mark.parametrize(("low", "height"), [(0.0, 0.05), (0.2, 2.0), (-1.0, 1.05)])
def test_colliders_away_from_the_height_of_agents_are_refused(low: float, height: float) -> None:
    floating = replace(body(0.0, 0.0, collider=BoxCollider(1.0, 1.0, height)), position=(0.0, 0.0, low))
    expected = f"body 'box' is solid from {low:g} to {low + height:g} units above the ground, expected .* at 0.1"
    with pytest.raises(ValueError, match=expected):
        Footprints(scene(floating))
    with pytest.raises(ValueError, match=expected):
        Footprints(scene()).way_is_free((0.0, 0.0), (0.0, 1.0), added=[floating])


def test_added_bodies_need_a_collider() -> None:
    with pytest.raises(ValueError, match="body 'box' has no collider"):
        Footprints(scene()).way_is_free((0.0, 0.0), (0.0, 1.0), added=[body(0.0, 0.0, collider=None)])


def test_every_collider_of_the_project_counts_by_its_footprint() -> None:
    """So nothing that can be built is refused, and nothing of it needs more than plane geometry."""
    found = 0
    for kind in FURNITURE:
        for colour in ("", *COLOURS.get(kind, ()), *IMPORTED_COLOURS.get(kind, ())):
            collider = piece_of(kind, colour).collider
            if collider is not None:
                Footprint.of(body(0.0, 0.0, collider=collider))
                found += 1
    for built in (room_scene(), *(city_scene(section_of(section_id)) for section_id in ALL)):
        solid = [each for each in built.bodies if each.collider is not None]
        found += len([Footprint.of(each) for each in solid])
    assert found > 1000
