"""Agreement of verifiers on one text: their ways, their cells, their flags. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, pairwise
from statistics import fmean

from arramon_server.scoring.metrics import ndtw

CACHED_PAIRS = 50_000
"""Number of pairs of ways whose similarity is kept: a host's pages ask for all of a collection again and again."""

Path = tuple[tuple[float, float], ...]
"""Positions (x, z) of a walk, in order, in units."""

PlacedCell = tuple[int, int, int] | None
"""Cell (column, level, row) in which an object was placed; None if it was not."""


@dataclass(frozen=True, slots=True)
class Walk:
    """One verification of a text.

    Attributes:
        worker_id: the verifier.
        paths: ways of turn 1 and turn 2; an empty one was not begun.
        cells: cells in which the objects of turn 1 and turn 2 were placed.
        flags: flags that the verifier set, such as "1-navigation-unclear".
    """

    worker_id: str
    paths: tuple[Path, Path]
    cells: tuple[PlacedCell, PlacedCell]
    flags: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of the verifiers of one text, as means over their pairs and both turns; None with fewer than two.

    Attributes:
        path: nDTW between two ways, in both directions.
        cell: share of pairs that placed the object in the same cell.
    """

    path: float | None
    cell: float | None


@lru_cache(CACHED_PAIRS)
def path_similarity(one: Path, other: Path) -> float:
    """Return the mean nDTW of two ways in both directions, 0 to 1; 0 if one is empty."""
    if not one or not other:
        return 0.0
    return (ndtw(one, other) + ndtw(other, one)) / 2.0


def agreement_of(walks: Sequence[Walk]) -> Agreement:
    """Return the agreement of the verifiers of one text."""
    return _means(list(combinations(walks, 2)))


def agreement_with_others(worker_id: str, walks_by_text: Mapping[str, Sequence[Walk]]) -> Agreement:
    """Return the agreement of one verifier with the others of the same texts.

    Args:
        worker_id: the verifier.
        walks_by_text: all verifications of each text.
    """
    pairs = [
        (mine, other)
        for walks in walks_by_text.values()
        for mine in walks
        if mine.worker_id == worker_id
        for other in walks
        if other.worker_id != worker_id
    ]
    return _means(pairs)


def flag_alpha(walks_by_text: Mapping[str, Sequence[Walk]], flag_names: Sequence[str]) -> float | None:
    """Return Krippendorff's alpha (nominal) over all flags: each flag of each text is a unit, set or not set.

    Args:
        walks_by_text: all verifications of each text.
        flag_names: all flags that can be set.

    Returns:
        Alpha, at most 1; None if it is undefined: no text has two verifiers, or all of them chose the same everywhere.

    Raises:
        ModuleNotFoundError: if the package `krippendorff` is not installed.
    """
    import krippendorff  # not at the top: it is an extra

    workers = sorted({walk.worker_id for walks in walks_by_text.values() for walk in walks})
    units = [(text_id, name) for text_id in sorted(walks_by_text) for name in flag_names]
    index = {unit: column for column, unit in enumerate(units)}
    ratings = [[float("nan")] * len(units) for _ in workers]
    for text_id, walks in walks_by_text.items():
        for walk in walks:
            row = ratings[workers.index(walk.worker_id)]
            for name in flag_names:
                row[index[text_id, name]] = float(name in walk.flags)
    if not _is_rated_twice(ratings) or len({one for row in ratings for one in row if one == one}) < 2:
        return None
    return float(krippendorff.alpha(reliability_data=ratings, level_of_measurement="nominal"))


def _is_rated_twice(ratings: Sequence[Sequence[float]]) -> bool:
    return any(sum(one == one for one in unit) > 1 for unit in zip(*ratings, strict=True))


def _means(pairs: Sequence[tuple[Walk, Walk]]) -> Agreement:
    if not pairs:
        return Agreement(None, None)
    paths = [path_similarity(one.paths[turn], other.paths[turn]) for one, other in pairs for turn in range(2)]
    cells = [
        float(one.cells[turn] is not None and one.cells[turn] == other.cells[turn])
        for one, other in pairs
        for turn in range(2)
    ]
    return Agreement(fmean(paths), fmean(cells))


def simplified(path: Sequence[tuple[float, float]]) -> Path:
    """Return a path without consecutive duplicates, rounded to centimetres, as it is stored."""
    rounded = [(round(x, 2), round(z, 2)) for x, z in path]
    return (*rounded[:1], *(later for earlier, later in pairwise(rounded) if later != earlier))
