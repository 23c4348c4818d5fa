"""The street graph of each of the seven plans, and properties of all of them."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from arramon_dataset.plans import plan_ids
from arramon_dataset.plans.graph import JUNCTIONS, ROADS, SIZES, Junction, StreetGraph
from arramon_dataset.plans.graph_builder import street_graph
from arramon_dataset.plans.street_surface import street_surface
from arramon_server.sim.city import city_scene
from tests.dataset.plans.sections import ALL, plan_of, section_of

JUNCTION_TABLE = {
    "1": (
        "-6 16 square 29:2 149:12 209:3 299:6",
        "-14 0 t_junction 29:3 119:5 299:4",
        "0 26 t_junction 119:10 209:0 299:7",
        "-10 8 t_junction 29:0 209:1 299:8",
        "-27 7 bend 29:8 119:1",
        "0 -7 bend 29:11 299:1",
        "-18 23 t_junction 29:7 119:0 209:8",
        "-12 33 bend 119:2 209:6",
        "-22 15 t_junction 29:6 119:3 209:4",
        "14 18 bend 209:13 299:10",
        "7 22 t_junction 119:9 209:12 299:2",
        "4 1 t_junction 29:13 209:5 329:12",
        "0 8 t_junction 29:10 149:11 329:0",
        "10 11 t_junction 29:9 119:14 209:11",
        "13 9 street_end 299:13",
    ),
    "2": (
        "38 -65 square 12:12",
        "27 -79 crossing 12:8 72:4 192:6 282:5",
        "15 -76 bend 12:10 102:5",
        "47 -73 t_junction 12:11 192:13 252:4",
        "37 -76 t_junction 72:3 192:14 252:1",
        "19 -77 t_junction 102:1 192:15 282:2",
        "26 -90 bend 12:1 102:14",
        "30 -56 t_junction 102:12 192:8 282:9",
        "27 -68 t_junction 12:7 192:1 282:10",
        "20 -53 bend 102:7 192:10",
        "17 -66 t_junction 12:9 102:8 192:2",
        "50 -60 bend 192:3 282:12",
        "39 -58 t_junction 102:11 192:0 282:7",
        "42 -94 bend 12:3 282:14",
        "34 -92 t_junction 12:4 102:13 282:6",
        "18 -85 street_end 12:5",
    ),
    "3": (
        "-61 -54 square 61:7 151:3 241:8",
        "-37 -59 bend 241:5 331:6",
        "-47 -64 t_junction 61:5 241:3 331:7",
        "-56 -69 t_junction 61:2 241:4 331:0",
        "-64 -74 bend 61:3 331:8",
        "-42 -62 t_junction 61:1 151:13 241:2",
        "-43 -48 t_junction 151:1 241:7 331:9",
        "-51 -53 crossing 61:6 151:2 241:0 331:11",
        "-71 -64 t_junction 1:10 61:0 151:4",
        "-49 -37 bend 151:6 241:11",
        "-71 -49 bend 61:12 181:8",
        "-56 -41 t_junction 61:9 151:7 241:12",
        "-62 -44 t_junction 61:11 241:10 331:14",
        "-39 -67 street_end 331:5",
        "-64 -40 street_end 151:12",
    ),
    "4": (
        "68 16 square 45:8 135:2 195:9 285:10 345:5",
        "79 27 t_junction 135:11 225:8 315:13",
        "81 3 crossing 15:6 135:14 255:3 315:0",
        "63 -1 fork 15:9 75:2 315:7",
        "53 20 t_junction 15:12 105:10 195:7",
        "64 31 t_junction 75:13 165:0 255:12",
        "84 14 t_junction 15:11 195:2 315:8",
        "51 11 fork 15:4 135:3 255:15",
        "75 23 t_junction 45:1 135:6 225:0",
        "65 6 t_junction 15:0 195:3 330:10",
        "58 19 t_junction 105:0 150:9 285:4",
        "85 21 bend 195:6 315:1",
        "55 29 bend 75:5 195:4",
        "73 33 bend 135:1 255:5",
        "84 0 street_end 315:2",
        "47 10 street_end 75:7",
    ),
    "5": (
        "5 148 square 6:2 96:5 186:4 216:1 276:7",
        "-7 134 t_junction 6:0 96:4 276:9",
        "3 162 crossing 96:10 186:0 276:8 336:12",
        "17 133 bend 6:6 276:4",
        "4 134 t_junction 6:0 96:3 276:1",
        "18 148 t_junction 186:6 276:0 336:10",
        "17 140 t_junction 6:5 96:13 186:3",
        "-14 148 t_junction 6:11 96:0 186:9",
        "-5 162 t_junction 96:2 186:14 276:11",
        "-15 133 bend 6:7 96:1",
        "13 161 bend 156:5 276:2",
        "-13 163 bend 96:8 186:7",
        "0 166 street_end 156:2",
        "23 139 street_end 276:6",
        "-6 155 street_end 6:8",
    ),
    "6": (
        "-87 93 square 163:3 253:2 343:6",
        "-113 89 fork 73:2 103:5 343:11",
        "-99 93 crossing 73:0 163:4 253:1 343:9",
        "-80 81 t_junction 163:7 283:4 343:0",
        "-96 84 crossing 103:3 193:13 283:5 343:2",
        "-107 87 t_junction 103:4 193:14 283:1",
        "-89 110 bend 163:0 253:12",
        "-77 70 bend 283:13 343:3",
        "-103 106 t_junction 73:12 163:9 253:10",
        "-101 100 t_junction 163:2 253:11 343:8",
        "-115 102 bend 73:8 163:11",
        "-113 96 t_junction 73:9 163:1 343:10",
        "-96 108 t_junction 73:6 163:15 253:8",
        "-99 73 t_junction 13:4 103:7 283:14",
        "-110 74 bend 13:5 103:13",
        "-94 103 street_end 343:12",
    ),
    "7": (
        "121 -59 square 130:4 220:10 310:3",
        "101 -65 bend 40:7 130:9",
        "118 -79 t_junction 40:6 130:16 310:9",
        "110 -55 t_junction 53:5 130:0 220:7",
        "126 -70 crossing 25:8 130:17 220:6 310:0",
        "127 -52 t_junction 40:11 145:8 295:3",
        "123 -74 t_junction 40:4 220:2 310:10",
        "106 -60 t_junction 40:3 220:1 310:14",
        "131 -62 t_junction 130:15 205:4 355:5",
        "110 -72 t_junction 40:10 130:2 310:1",
        "114 -67 t_junction 40:0 130:6 220:9",
        "131 -47 t_junction 130:13 220:5 310:12",
        "123 -40 bend 130:11 250:14",
        "139 -54 bend 190:15 310:11",
        "101 -56 bend 40:12 130:7",
        "135 -66 bend 40:13 310:8",
        "122 -83 street_end 310:2",
        "129 -74 street_end 310:4",
    ),
}
"""Of each section: x, z and kind of its junctions, and the heading of each arm with the number of the junction that it
leads to."""

ROAD_TABLE = {
    "1": (10, 2, 22),
    "2": (11, 3, 24),
    "3": (11, 2, 22),
    "4": (9, 3, 24),
    "5": (10, 3, 20),
    "6": (12, 3, 25),
    "7": (12, 4, 27),
}
"""Of each section: the number of its roads, of alleys among them, and of corners of blocks."""

each_own = pytest.mark.parametrize("section_id", plan_ids())
each_section = pytest.mark.parametrize("section_id", ALL)


@cache
def graph_of(section_id: str) -> StreetGraph:
    return street_graph(plan_of(section_id), section_of(section_id))


@each_own
def test_junctions(section_id: str) -> None:
    found = [
        f"{round(junction.x)} {round(junction.z)} {junction.kind} "
        + " ".join(f"{round(arm.heading)}:{arm.leads_to.removeprefix('junction/')}" for arm in junction.arms)
        for junction in graph_of(section_id).junctions
    ]
    assert tuple(found) == JUNCTION_TABLE[section_id]


@each_own
def test_roads_and_corners(section_id: str) -> None:
    graph = graph_of(section_id)
    alleys = sum(road.kind == "alley" for road in graph.roads)
    assert (len(graph.roads), alleys, len(graph.corners)) == ROAD_TABLE[section_id]
    assert {road.kind for road in graph.roads} == set(ROADS)
    assert [road.name for road in graph.roads] == [street.name for street in plan_of(section_id).streets]


@each_section
def test_identities_are_unique_and_buildings_have_those_of_their_bodies(section_id: str) -> None:
    graph = graph_of(section_id)
    names = [junction.identity for junction in graph.junctions] + [road.identity for road in graph.roads]
    names += [corner.identity for corner in graph.corners] + [building.identity for building in graph.buildings]
    assert len(set(names)) == len(names)
    bodies = {body.name for body in city_scene(section_of(section_id)).bodies}
    assert {building.identity for building in graph.buildings} == {
        name for name in bodies if name.startswith("building/")
    }
    assert {corner.building for corner in graph.corners} <= bodies
    assert {building.size for building in graph.buildings} <= set(SIZES)


@each_section
def test_a_way_leads_back(section_id: str) -> None:
    graph = graph_of(section_id)
    for junction in graph.junctions:
        assert junction.kind in JUNCTIONS
        for arm in junction.arms:
            assert junction.identity in [back.leads_to for back in graph.junction(arm.leads_to).arms]
            assert junction.identity in graph.road(arm.road).junctions


@each_section
def test_junctions_corners_and_houses_lie_where_they_should(section_id: str) -> None:
    graph, ground = graph_of(section_id), street_surface(plan_of(section_id))
    middles = np.array([(junction.x, junction.z) for junction in graph.junctions])
    assert ground.covers(middles).all()
    assert not ground.covers(np.array([(building.x, building.z) for building in graph.buildings])).any()
    for junction in graph.junctions:
        assert graph.junction_at(junction.x, junction.z) == junction
        assert [a.heading < b.heading for a, b in pairwise(junction.arms)] == [True] * (len(junction.arms) - 1)
        for arm in junction.arms:
            assert arm.road in [road.identity for road in graph.roads_at(arm.x, arm.z)]


@pytest.mark.parametrize(
    ("number", "heading", "kind"),
    [
        (1, 208.8, "t_junction"),
        (1, 118.8, "left_turn"),
        (1, 298.8, "right_turn"),
        (3, 28.8, "left_turn"),
        (4, 298.8, "right_turn"),
        (4, 208.8, "left_turn"),
        (0, 28.8, "square"),
        (14, 118.8, "street_end"),
    ],
)
def test_a_junction_looks_different_from_each_side(number: int, heading: float, kind: str) -> None:
    """High Street meets Bridge Street (1) and Cooper's Alley (3); Mill Street meets Bridge Street at a corner (4)."""
    junction: Junction = graph_of("1").junctions[number]
    assert junction.kind_from(heading) == kind


def test_an_unknown_identity_is_an_error() -> None:
    with pytest.raises(KeyError, match="junction/99"):
        graph_of("1").junction("junction/99")
    with pytest.raises(KeyError, match="street/99"):
        graph_of("1").road("street/99")
