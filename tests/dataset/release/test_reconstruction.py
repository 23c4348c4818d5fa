"""Reconstruction of a section's buildings from paths: streets stay free, walls close them, and lots fit."""

import json
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from arramon_client.world import AGENT_RADIUS, FACADES, FURNITURE
from arramon_dataset.layout.grid import CELL, Grid, Points, sample_points, to_street_frame
from arramon_dataset.layout.lots import CellRectangle, cover_with_rectangles, split_into_lots
from arramon_dataset.layout.prop_places import half_size
from arramon_dataset.randomness import seeded
from arramon_dataset.release.reconstruction import remove_thin, street_heading
from arramon_server.sim.assets.furniture import footprint_radius
from arramon_server.sim.geometry import Pose
from arramon_server.sim.section import Prop, Section
from benchmarks.release.drawn_furniture import COUNTS, reconstruct
from tests.release import VAL_SEEN, needs_release

NO_PLACES: Points = np.zeros((0, 2))


def walk(*corners: tuple[float, float], heading: float = 28.8) -> Points:
    """A path in unit steps through corners given as (across, along) in a frame turned by `heading`."""
    points = []
    for (a0, l0), (a1, l1) in pairwise(corners):
        steps = round(max(abs(a1 - a0), abs(l1 - l0)))
        points += [(a0 + (a1 - a0) * i / steps, l0 + (l1 - l0) * i / steps) for i in range(steps)]
    return to_street_frame(np.array([*points, corners[-1]], dtype=float), -heading)


def town(heading: float = 28.8) -> list[Points]:
    """Streets 3 wide about two blocks, and one that ends in the void."""
    paths = []
    for lane in (-1.5, 0.0, 1.5):
        near, far = lane, 18.0 + lane
        paths.append(
            walk((near, near), (near, far), (36 - near, far), (36 - near, near), (near, near), heading=heading)
        )
        paths.append(walk((18 + lane, 0), (18 + lane, 30), heading=heading))
    return paths


def gaps(section: Section, points: Points) -> Points:
    """(n,): how far each point is from the nearest building."""
    nearest = np.full(len(points), np.inf)
    for building in section.buildings:
        local = np.abs(to_street_frame(points - (building.x, building.z), building.heading))
        outside = np.maximum(local - (building.half_width, building.half_length), 0.0)
        nearest = np.minimum(nearest, np.hypot(outside[:, 0], outside[:, 1]))
    return nearest


def standing(section: Section) -> Iterator[Prop]:
    return (prop for prop in section.props if prop.kind != "banner")


def check_free(section: Section, paths: list[Points], targets: Points) -> None:
    walked = sample_points(paths)
    assert gaps(section, np.concatenate([walked, targets])).min() >= 0.5
    for prop in standing(section):
        from_path = np.hypot(*(walked - (prop.x, prop.z)).T).min()
        assert from_path >= AGENT_RADIUS + footprint_radius(prop.kind) + 0.1, prop
        if len(targets):
            assert np.hypot(*(targets - (prop.x, prop.z)).T).min() >= 0.4 + footprint_radius(prop.kind), prop


def sees_the_void(section: Section, place: Points) -> bool:
    """Whether someone at `place` could walk out of the world between the buildings."""
    centres = np.array([(b.x, b.z) for b in section.buildings])
    grid = Grid.around(centres, section.heading, 15.0)
    solid = (gaps(section, grid.centres()) < CELL / 2).reshape(grid.shape)
    labels, _ = ndimage.label(~solid)
    across, along = ((to_street_frame(place, section.heading)[0] - grid.origin) / CELL).astype(int)
    return bool(labels[across, along] == labels[0, 0])


@pytest.mark.parametrize(
    ("heading", "turned", "expected"),
    [
        (28.8, 0.0, 118.8),
        (28.8, 90.0, 28.8),
        (0.0, 0.0, 90.0),
        (89.9, 0.0, 179.9),
        (45.0, 0.0, 135.0),
        (0.0, 90.0, 0.0),
    ],
)
def test_street_heading_is_the_most_walked_direction(heading: float, turned: float, expected: float) -> None:
    paths = [walk((0, 0), (20, 0), (20, 10), (25, 15), heading=heading + turned), walk((0, 0), (0, 1), heading=heading)]

    assert street_heading(paths) % 180.0 == pytest.approx(expected % 180.0, abs=0.11)


def test_street_heading_without_movement_is_north() -> None:
    assert street_heading([np.array([[3.0, 4.0]])]) == 0.0


def test_reconstruction_without_paths_is_an_error() -> None:
    with pytest.raises(ValueError, match="section 7"):
        reconstruct("7", [], NO_PLACES)


def test_single_point_is_enclosed_by_buildings() -> None:
    section = reconstruct("1", [np.array([[3.0, 4.0]])], NO_PLACES)

    assert len(section.buildings) >= 4
    assert not sees_the_void(section, np.array([[3.0, 4.0]]))


def test_blocks_are_built_up_and_streets_are_free() -> None:
    paths, targets = town(), to_street_frame(np.array([[9.0, 3.0], [27.0, 15.0]]), -28.8)
    section = reconstruct("1", paths, targets)

    check_free(section, paths, targets)
    blocks = to_street_frame(np.array([[9.0, 9.0], [27.0, 9.0], [-8.0, 9.0], [9.0, -8.0], [9.0, 26.0]]), -28.8)
    assert (gaps(section, blocks) == 0.0).all()
    assert not sees_the_void(section, paths[0][:1])
    assert section.heading in (28.8, 118.8)
    assert 20 <= len(section.buildings) <= 200
    assert {building.heading for building in section.buildings} == {section.heading}


def test_buildings_have_reasonable_sizes_and_do_not_overlap() -> None:
    section = reconstruct("1", town(), NO_PLACES)
    boxes = []
    for building in section.buildings:
        (across, along), halves = (
            to_street_frame(np.array([[building.x, building.z]]), section.heading)[0],
            (
                building.half_width,
                building.half_length,
            ),
        )
        boxes.append((across - halves[0], along - halves[1], across + halves[0], along + halves[1]))
        assert max(halves) <= 4.5
        assert 2.5 <= building.height <= 9.0
        assert building.facade in FACADES
    for i, (left, near, right, far) in enumerate(boxes):
        for other in boxes[:i]:
            overlap = (min(right, other[2]) - max(left, other[0]), min(far, other[3]) - max(near, other[1]))
            assert min(overlap) < 0.01


def test_section_bounds_contain_all_paths() -> None:
    paths = town()
    x0, z0, x1, z1 = reconstruct("1", paths, NO_PLACES).bounds
    points = np.concatenate(paths)

    assert (points.min(axis=0) > (x0, z0)).all()
    assert (points.max(axis=0) < (x1, z1)).all()


def test_section_is_determined_by_input_and_id() -> None:
    one, again, other = (reconstruct(name, town(), NO_PLACES) for name in ("1", "1", "2"))

    assert one == again
    assert one.buildings != other.buildings
    assert one.props != other.props


NOT_IN_THE_ORIGINAL = {"car", "kiosk", "planter", "awning", "shop_sign", "zebra_crossing"}
"""Kinds that none of the original benchmark's instructions names."""


def test_furniture_is_spaced_apart_and_of_every_kind() -> None:
    section = reconstruct("1", town(), NO_PLACES)
    kinds = Counter(prop.kind for prop in section.props)

    assert 60 <= len(section.props) <= 100
    assert set(kinds) == set(COUNTS) == set(FURNITURE) - NOT_IN_THE_ORIGINAL
    assert kinds.most_common(1)[0][0] == "cone"
    props = list(standing(section))
    for i, prop in enumerate(props):
        for other in props[:i]:
            apart = np.hypot(prop.x - other.x, prop.z - other.z)
            assert apart > footprint_radius(prop.kind) + footprint_radius(other.kind)


def test_furniture_does_not_overlap_buildings() -> None:
    section = reconstruct("1", town(), NO_PLACES)
    for prop in standing(section):
        half_width, half_length = half_size(prop.kind)
        pose = Pose(prop.x, prop.z, prop.heading)
        edges = [pose.ahead(half_length), pose.ahead(-half_length)]
        edges += [pose.turned(90).ahead(half_width), pose.turned(90).ahead(-half_width)]
        assert gaps(section, np.array([(edge.x, edge.z) for edge in edges])).min() > 0.0, prop


def test_banners_hang_on_walls_and_face_the_street() -> None:
    section = reconstruct("1", town(), NO_PLACES)
    banners = [prop for prop in section.props if prop.kind == "banner"]

    assert len(banners) >= 5
    for banner in banners:
        assert banner.shape
        assert banner.colour != banner.shape_colour
        pose = Pose(banner.x, banner.z, banner.heading)
        front, behind = pose.ahead(0.4), pose.ahead(-0.1)
        assert gaps(section, np.array([(banner.x, banner.z)]))[0] < 0.01
        assert gaps(section, np.array([(behind.x, behind.z)]))[0] == 0.0
        assert gaps(section, np.array([(front.x, front.z)]))[0] > 0.3


@settings(max_examples=12, deadline=None)
@given(
    st.lists(st.tuples(st.integers(-12, 12), st.integers(-12, 12)), min_size=2, max_size=6, unique=True),
    st.floats(0.0, 89.0),
)
def test_every_path_can_be_followed(corners: list[tuple[int, int]], heading: float) -> None:
    paths = [walk(*corners, heading=heading)]
    targets = paths[0][-1:] + np.array([0.0, 1.5])
    section = reconstruct("1", paths, targets)

    check_free(section, paths, targets)


def test_thin_slivers_are_removed_and_squares_kept() -> None:
    mask = np.zeros((60, 60), dtype=bool)
    mask[10:13, :] = True
    mask[30:50, 20:45] = True

    kept = remove_thin(mask, 2.5)

    assert not kept[10:13, 15:45].any()
    assert kept[30:50, 20:45].all()


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20), st.integers(1, 9), st.integers(1, 9)), max_size=8))
def test_rectangles_cover_the_mask_exactly_once(boxes: list[tuple[int, int, int, int]]) -> None:
    mask = np.zeros((30, 30), dtype=bool)
    for top, left, height, width in boxes:
        mask[top : top + height, left : left + width] = True

    count = np.zeros(mask.shape, dtype=int)
    for rectangle in cover_with_rectangles(mask, 1):
        count[rectangle.top : rectangle.bottom, rectangle.left : rectangle.right] += 1

    assert (count == mask).all()


@given(st.integers(1, 80), st.integers(1, 80), st.integers())
def test_rectangle_is_split_into_lots_of_allowed_sizes(height: int, width: int, seed: int) -> None:
    lots = split_into_lots(CellRectangle(0, 0, height, width), 8, 20, seeded(seed))

    assert sum(lot.shape[0] * lot.shape[1] for lot in lots) == height * width
    assert all(min(height, 8) <= lot.shape[0] <= 20 for lot in lots)
    assert all(min(width, 8) <= lot.shape[1] <= 20 for lot in lots)


@needs_release
@pytest.mark.parametrize(("section_id", "first", "last"), [("1", 1, 14999), ("5", 45000, 54999)])
def test_streets_of_the_official_release_are_free(section_id: str, first: int, last: int) -> None:
    episodes = json.loads(VAL_SEEN.read_text(encoding="utf-8"))
    episodes = [episode for episode in episodes if first <= episode["mapId"] <= last]
    paths = [np.array(path)[:, [0, 2]] for e in episodes for path in e["gt_paths"]["navi_path_gt"]]
    targets = np.array([place for e in episodes for place in e["gt_objects_pos"]["navi_obj_pos_gt"]])[:, [0, 2]]
    section = reconstruct(section_id, paths, targets)

    check_free(section, paths, targets)
    assert not sees_the_void(section, paths[0][:1])
    assert section.heading in (28.8, 118.8)
    assert 60 <= len(section.props) <= 100
