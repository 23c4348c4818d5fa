"""Paired comparisons of all ranked standings of a listing, cached by the set of their runs."""

import math
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np
import numpy.typing as npt

from arramon_server.board.episode_table import EpisodeTable, join_languages, mean_table
from arramon_server.board.standings import HEADLINE, TOTAL, ScoresVersion, Standing
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.masking import Noise, p_value_class, shown_deviation, shown_difference
from arramon_server.scoring.paired import MeanDifference, difference_bounds, holm, permutation_tests

SIGNIFICANCE_LEVEL = 0.05
"""Maximum probability of any false claim in a family of comparisons."""

_MAX_FAMILIES = 12
"""Maximum number of cached families: 2 MB each for 200 runs of 1205 episodes."""

ScoreVersions = tuple[tuple[ScoresVersion, ...], ...]
"""Score versions of a standing's runs: a tuple per language, with one version per seed."""


@dataclass(frozen=True, slots=True)
class PairComparison:
    """Comparison of two standings: the first minus the second.

    Attributes:
        difference: mean difference with its interval, and the uncorrected p-value.
        corrected: p-value corrected for all pairs of the family by Holm's procedure.
        shown: 1 if the first is significantly better, -1 if it is significantly worse, otherwise 0.
    """

    difference: MeanDifference
    corrected: float
    shown: int


class ComparisonFamily:
    """Family of tests: all pairs of a listing's ranked standings, compared by one metric.

    Args:
        keys: keys of the standings.
        scores: score of each standing in each episode, (standings, episodes).
        strata: number of each episode's stratum, (episodes,).
        noise: on a hidden split, scores of each standing in made-up episodes, which the tests treat like real ones; see
            `arramon_server.scoring.masking`. Differences and their intervals then follow from the shown means.
        metric: metric to compare.
    """

    def __init__(
        self,
        keys: Sequence[ScoreVersions],
        scores: Floats,
        strata: npt.NDArray[np.intp],
        noise: Floats | None = None,
        metric: str = HEADLINE,
    ) -> None:
        self._place = {key: number for number, key in enumerate(keys)}
        self._scores, self._strata = scores, strata
        self._metric, self._masked = metric, noise is not None
        if noise is not None:
            scores = np.hstack([scores, noise])
        self._p = permutation_tests(scores) if len(keys) > 1 else np.ones((len(keys), len(keys)))
        self._corrected = np.ones_like(self._p)
        pairs = np.triu_indices(len(keys), 1)
        self._corrected[pairs] = holm(self._p[pairs])
        self._corrected = np.minimum(self._corrected, self._corrected.T)
        means = scores.sum(axis=1)
        self._better = transitive_closure((self._corrected < SIGNIFICANCE_LEVEL) & (means[:, None] > means))

    def rank_range(self, standing: Standing) -> tuple[int, int]:
        """Return the best and the worst rank that a standing can have, given all significant differences.

        The best is one more than the number of significantly better standings; the worst is the number of standings
        minus the number of significantly worse ones.
        """
        at = self._place[versions_of_standing(standing)]
        return 1 + int(self._better[:, at].sum()), len(self._place) - int(self._better[at].sum())

    def compare(self, one: Standing, other: Standing) -> PairComparison:
        """Return the comparison of two ranked standings."""
        a, b = self._place[versions_of_standing(one)], self._place[versions_of_standing(other)]
        shown = int(self._better[a, b]) - int(self._better[b, a])
        p, corrected = float(self._p[a, b]), float(self._corrected[a, b])
        if self._masked:
            found = masked_difference(one, other, self._metric, len(self._strata))
            return PairComparison(
                MeanDifference(found.mean, found.low, found.high, p_value_class(p)), p_value_class(corrected), shown
            )
        bounds = difference_bounds(self._scores[a] - self._scores[b], self._strata)
        return PairComparison(MeanDifference(*bounds, p=p), corrected, shown)


def masked_difference(one: Standing, other: Standing, metric: str, episodes: int) -> Interval:
    """Return the difference of two standings' shown totals on a hidden split, with an interval from these totals alone.

    Args:
        one, other: the standings.
        metric: metric that is compared.
        episodes: number of episodes that both played.
    """
    first, second = (line.rows[TOTAL][metric].mean for line in (one, other))
    return shown_difference(first, second, episodes, math.sqrt(2.0) * shown_deviation(episodes))


class ComparisonCache:
    """Cache of comparison families, one for each set of runs and metric. Thread-safe.

    Args:
        read: returns the scores of a published run by episode.
        noise: returns the noise of a split if it is hidden; None if it is open.
    """

    def __init__(self, read: Callable[[ScoresVersion], EpisodeTable], noise: Callable[[str], Noise | None]) -> None:
        self._read, self._noise = read, noise
        self._kept: OrderedDict[object, ComparisonFamily] = OrderedDict()
        self._lock = Lock()

    def family(self, standings: Sequence[Standing], metric: str, section_of: Mapping[str, str]) -> ComparisonFamily:
        """Return the tests of all pairs of standings that played the same episodes.

        Args:
            standings: ranked standings of one listing.
            metric: metric whose total is compared, one of METRICS.
            section_of: section of every episode, by id.
        """
        keys = tuple(sorted(versions_of_standing(standing) for standing in standings))
        noise = self._noise(standings[0].entries[0].run.split) if standings else None
        with self._lock:
            found = self._kept.pop((keys, metric), None) or self._make(keys, metric, section_of, noise)
            self._kept[keys, metric] = found
            while len(self._kept) > _MAX_FAMILIES:
                self._kept.popitem(last=False)
        return found

    def _make(
        self, keys: Sequence[ScoreVersions], metric: str, section_of: Mapping[str, str], noise: Noise | None
    ) -> ComparisonFamily:
        column = METRICS.index(metric)
        scores, added, strata = [], [], np.zeros(0, np.intp)
        for key in keys:
            tables = [[self._read(version) for version in runs] for runs in key]
            joined = join_languages([mean_table(runs) for runs in tables], section_of)
            scores.append(joined.values[:, -1, column])
            strata = joined.strata
            if noise is not None:
                added.append(_noise_of(tables, noise, metric))
        made_up = None if noise is None else np.array(added)
        return ComparisonFamily(keys, np.array(scores).reshape(len(keys), len(strata)), strata, made_up, metric)


def _noise_of(tables: Sequence[Sequence[EpisodeTable]], noise: Noise, metric: str) -> Floats:
    """Return a standing's scores in made-up episodes, (MIN_EPISODES,): means over its seeds and languages."""
    languages = [np.mean([noise.test_scores(table.play_digest, metric) for table in runs], axis=0) for runs in tables]
    mean: Floats = np.mean(languages, axis=0)
    return mean


def versions_of_standing(standing: Standing) -> ScoreVersions:
    """Return the score versions of a standing's runs."""
    return tuple(tuple(entry.version for entry in entries) for entries in standing.by_language)


def transitive_closure(better: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the transitive closure of the relation "is better than", a square matrix."""
    while True:
        counts = better.astype(np.float32)
        further = better | (counts @ counts > 0.0)
        if np.array_equal(further, better):
            return better
        better = further
