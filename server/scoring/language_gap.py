"""Gap between the languages of one agent on the same episodes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.paired import difference_bounds


@dataclass(frozen=True, slots=True)
class LanguageGap:
    """Difference between the languages with the highest and the lowest mean, over the episodes that all languages have.

    Attributes:
        higher, lower: codes of the two languages; the first two if all means are equal.
        mean: mean of the differences, at least 0.
        low, high: 95% interval of the difference, in [-1, 1].
        same: share of the episodes with the same outcome of both turns in all languages.
        episodes: number of the episodes.
    """

    higher: str
    lower: str
    mean: float
    low: float
    high: float
    same: float
    episodes: int


def language_gap(
    languages: Sequence[str], scores: Floats, outcomes: Floats, strata: npt.NDArray[np.intp]
) -> LanguageGap:
    """Return the gap between two or more languages.

    Args:
        languages: codes of the languages.
        scores: score of each episode in each language, (languages, episodes).
        outcomes: outcomes of both turns of each episode in each language, (languages, episodes, 2).
        strata: number of each episode's stratum, (episodes,).
    """
    means = scores.mean(axis=1)
    higher, lower = int(np.argmax(means)), int(np.argmin(means))
    if higher == lower:
        higher, lower = 0, 1
    mean, low, high = difference_bounds(scores[higher] - scores[lower], strata)
    same = float((outcomes == outcomes[0]).all(axis=(0, 2)).mean())
    return LanguageGap(languages[higher], languages[lower], mean, low, high, same, scores.shape[1])
