"""Sections built from plans: walkable streets, closed boundaries, and dense landmarks."""

import hashlib
from collections import Counter
from contextlib import closing
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from arramon_client.world import AGENT_RADIUS, FACADES
from arramon_dataset.layout.grid import sample_points
from arramon_dataset.plans import build_section, read_plan
from arramon_dataset.plans.street_furniture import crossings, distances
from arramon_dataset.plans.street_surface import street_surface
from arramon_server.episodes.split_files import write_section
from arramon_server.sim.cameras import NOTHING, Viewpoint
from arramon_server.sim.city import city_scene, label_of_prop
from arramon_server.sim.physics import physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.section import Section
from tests.dataset.plans.free_points import CELL, clearance, free_points
from tests.dataset.plans.sections import ALL, plan_of, section_of

DIGESTS = ["d50d3903", "8d0c1455", "87661c79", "2e6c9505", "8f14399d", "d3ca22e1", "1d0f6a06"]
"""Of the seven sections' files."""

DRAWN_DIGESTS = ["88466b78", "fc77b0a1"]
"""Of the drawn sections' files."""

each_section = pytest.mark.parametrize("section_id", ALL)


@each_section
def test_all_streets_are_connected_free_ground(section_id: str) -> None:
    free = free_points(section_of(section_id), 0.2)
    middles = sample_points(plan_of(section_id).lines(), 0.5)
    ends = np.concatenate([line[[0, -1]] for line in plan_of(section_id).lines()])
    inner = middles[distances(middles, ends).min(axis=1) > 0.75]
    assert distances(inner, free).min(axis=1).max() < 0.3


@each_section
def test_reachable_ground_stays_on_the_streets(section_id: str) -> None:
    section = section_of(section_id)
    x0, z0, x1, z1 = section.bounds
    start = free_points(section, 0.5)[0]
    reached = np.array(reachable(replace(section, bounds=(x0 - 12, z0 - 12, x1 + 12, z1 + 12)), start[0], start[1]))
    ground = street_surface(plan_of(section_id))
    apart = np.min([strip.distance(reached) for strip in ground.strips], axis=0)
    beyond = ~ground.covers(reached) & (apart > 1.5)
    assert not beyond.any(), reached[beyond]
    assert len(reached) > 2300


def reachable(section: Section, x: float, z: float) -> list[tuple[float, float]]:
    """Where a walker in steps of half a unit gets to from (x, z), however close to walls."""
    x0, z0 = section.bounds[:2]
    free = clearance(section) > AGENT_RADIUS - CELL
    todo, seen = [(x, z)], set[tuple[float, float]]()
    while todo:
        place = todo.pop()
        cell = int((place[0] - x0) / CELL), int((place[1] - z0) / CELL)
        outside = not (0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1])
        if place in seen or outside or not free[cell]:
            continue
        seen.add(place)
        todo += [(place[0] + dx, place[1] + dz) for dx, dz in ((0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))]
    return sorted(seen)


@each_section
def test_views_from_the_streets_never_show_an_empty_horizon(section_id: str) -> None:
    camera = RasterCamera(city_scene(section_of(section_id)))
    for x, z in free_points(section_of(section_id), 1.0)[::20].tolist():
        for heading in range(0, 360, 60):
            frame = camera.render(Viewpoint(x, z, heading), [], 64, segmentation=True)
            assert frame.segmentation is not None
            assert (frame.segmentation[31] != camera.labels.index(NOTHING)).all(), (x, z, heading)


@each_section
def test_free_points_are_free_in_the_physics(section_id: str) -> None:
    points = free_points(section_of(section_id), 1.0)
    assert 600 < len(points) < 1100
    with closing(physics_of(city_scene(section_of(section_id)))) as physics:
        for x, z in points[::7].tolist():
            assert physics.way_is_free((x, z), (x + 0.01, z)), (x, z)


@each_section
def test_section_extent_is_30_to_50_units(section_id: str) -> None:
    x0, z0, x1, z1 = section_of(section_id).bounds
    assert 30 < x1 - x0 < 50
    assert 30 < z1 - z0 < 50


def test_sections_are_far_from_each_other() -> None:
    for one, other in combinations([section_of(section_id).bounds for section_id in ALL], 2):
        apart = max(one[0] - other[2], other[0] - one[2], one[1] - other[3], other[1] - one[3])
        assert apart > 10.0


@each_section
def test_landmarks_are_dense_and_distinguishable(section_id: str) -> None:
    plan, section = plan_of(section_id), section_of(section_id)
    places = np.array([(prop.x, prop.z) for prop in section.props])
    labels = [label_of_prop(prop) for prop in section.props]
    assert 125 <= len(labels) <= 150
    assert 12 <= Counter(label.kind for label in labels)["banner"] <= 20
    assert len(set(labels)) >= 35
    assert distances(sample_points(plan.lines(), 1.0), places).min(axis=1).max() < 5.0
    assert (np.sort(distances(crossings(plan), places), axis=1)[:, 2] < 5.0).all()
    same = [
        np.hypot(*(places[i] - places[j]))
        for i, j in combinations(range(len(labels)), 2)
        if labels[i] == labels[j] and labels[i].kind != "zebra_crossing"
    ]
    assert min(same) > 7.0
    assert np.mean(np.array(same) < 12.0) < 0.1


@each_section
def test_nearest_buildings_have_different_facades(section_id: str) -> None:
    buildings = section_of(section_id).buildings
    assert {building.facade for building in buildings} == set(FACADES)
    assert min(building.height for building in buildings) < 2.6
    assert max(building.height for building in buildings) > 6.5
    places = np.array([(building.x, building.z) for building in buildings])
    apart = distances(places, places) + 1e9 * np.eye(len(places))
    nearest = apart.argmin(axis=1)
    alike = [i for i, j in enumerate(nearest) if buildings[i].facade == buildings[int(j)].facade]
    assert alike == []


def test_sections_are_the_same_on_every_machine(tmp_path: Path) -> None:
    """Whoever changes a plan or how it is built up changes all episodes that were ever made in it."""
    digests = []
    for section_id in ALL:
        write_section(tmp_path / section_id, section_of(section_id))
        digests.append(hashlib.sha256((tmp_path / section_id).read_bytes()).hexdigest()[:8])
    assert digests == [*DIGESTS, *DRAWN_DIGESTS]


def test_seed_changes_looks_and_furniture_but_not_building_places() -> None:
    plan = read_plan("7")
    assert build_section(plan, "arramon") == section_of("7")
    other = build_section(plan, "another secret")
    assert other.props != section_of("7").props
    assert other.bounds == section_of("7").bounds

    def places(section: Section) -> list[tuple[float, ...]]:
        return [(b.x, b.z, b.half_width, b.half_length, b.heading) for b in section.buildings]

    def looks(section: Section) -> list[tuple[str, float]]:
        return [(b.facade, b.height) for b in section.buildings]

    assert places(other) == places(section_of("7"))
    assert looks(other) != looks(section_of("7"))
