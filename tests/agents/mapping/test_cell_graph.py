"""The graph of neighbouring cells: its edges, and their lengths."""

import math

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from arramon_agents.mapping.cell_graph import cell_graph

CELL = 0.25

DIAGONAL, KNIGHT = math.sqrt(2.0), math.sqrt(5.0)

EDGES = [
    # open cells of a raster of 3 x 2, numbered row by row; pairs of connected cells, with their distance in cells
    ([0, 1], {(0, 1): 1.0}),
    ([0, 3], {(0, 3): DIAGONAL}),
    ([1, 2], {(1, 2): DIAGONAL}),
    ([0, 5], {(0, 5): KNIGHT}),
    ([0, 4], {}),
    ([0, 1, 4], {(0, 1): 1.0, (1, 4): KNIGHT}),
]


@pytest.mark.parametrize(("cells", "expected"), EDGES)
def test_open_neighbours_are_connected(cells: list[int], expected: dict[tuple[int, int], float]) -> None:
    is_open = np.zeros(6, bool)
    is_open[cells] = True
    edges = cell_graph(is_open.reshape(3, 2), np.ones((3, 2)), CELL).todok()
    assert {tuple(sorted(map(int, pair))): length for pair, length in edges.items()} == pytest.approx(
        {pair: distance * CELL for pair, distance in expected.items()}
    )


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_edge_has_the_mean_cost_of_its_cells_and_their_precision(kind: type[np.floating]) -> None:
    graph = cell_graph(np.ones((1, 3), bool), np.array([[1.0, 2.0, 4.0]], kind), 2.0)
    assert graph.dtype == kind
    assert dijkstra(graph, directed=False, indices=0).tolist() == [0.0, 3.0, 9.0]
