"""Word alignment model between instructions and routes; rejects generated texts that do not fit their route.

Each word of a text comes from one of the route's tokens, preferably one at the same relative position, or from none:
the model of Dyer, Chahuneau and Smith, "A Simple, Fast, and Effective Reparameterization of IBM Model 2" (2013). It
knows no grammar, no phrase and no list of nouns. `benchmarks/instructions/alignment_training.py` trains it.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from arramon.strict_json import read_json
from arramon_dataset.alignment.route_tokens import Tokens, mirrored
from arramon_server.episodes.split_files import read_bytes
from arramon_server.errors import BadFile

DATA = Path(__file__).parent / "data"

FROM_NONE, TENSION = 0.15, 5.0
"""Prior probability of no token; preference for tokens at the same relative position: a factor of e for each
1 / TENSION of the whole route."""

OTHERS, MOST_BETTER, MIRRORED_BETTER = 20, 8, 0.1
"""Number of comparison routes; maximum number of these that a text may fit better than its own route; maximum margin by
which it may fit the mirrored route better, in nats per word."""

DIGITS = 5
"""Decimal digits of a model's probabilities in its file."""

_WORD = re.compile(r"[a-z]+|[\u0900-\u0963\u0966-\u097f]+")

Floats = npt.NDArray[np.float64]


def words_of(text: str) -> list[str]:
    """Return the words of a text in Latin or Devanagari letters, in lower case."""
    return _WORD.findall(text.lower())


@dataclass(frozen=True, slots=True)
class AlignmentModel:
    """A trained word alignment model of one language.

    Attributes:
        words: index of each word.
        tokens: index of each route token; row 0 of `table` is for no token.
        table: probability of each word given each token, of shape (1 + tokens, words).
        others: routes of other texts, for comparison.
    """

    words: dict[str, int]
    tokens: dict[str, int]
    table: Floats
    others: tuple[Tokens, ...]

    def score(self, text: str, route: Sequence[str]) -> float:
        """Return the mean natural logarithm of the probability of the text's words given a route; 0 without words."""
        known, rows = self._indices(text, route)
        if not known:
            return 0.0
        return float(np.log(posteriors(self.table, known, rows).sum(axis=1)).mean())

    def margin(self, text: str, route: Tokens) -> float:
        """Return how much better a text fits a route than the mirrored route, in nats per word."""
        return self.score(text, route) - self.score(text, mirrored(route))

    def rank(self, text: str, route: Tokens) -> int:
        """Return the number of `others` that the text fits better than the route."""
        own = self.score(text, route)
        return sum(self.score(text, other) > own for other in self.others)

    def _indices(self, text: str, route: Sequence[str]) -> tuple[list[int], list[int]]:
        known = [self.words[word] for word in words_of(text) if word in self.words]
        return known, [self.tokens[token] for token in route if token in self.tokens]


def posteriors(table: Floats, words: Sequence[int], rows: Sequence[int]) -> Floats:
    """Return the posterior probabilities of no token and of each token for each word, of shape (words, 1 + tokens)."""
    at = (np.arange(len(words)) + 0.5) / max(len(words), 1)
    along = (np.arange(len(rows)) + 0.5) / max(len(rows), 1)
    near = np.exp(-TENSION * np.abs(at[:, None] - along[None, :]))
    near *= (1.0 - FROM_NONE) / np.maximum(near.sum(axis=1, keepdims=True), 1e-12)
    weights = np.concatenate([np.full((len(words), 1), FROM_NONE), near], axis=1)
    return weights * table[[0, *rows]][:, list(words)].T


def read_model(path: Path) -> AlignmentModel:
    """Return the model in a file.

    Raises:
        BadFile: if the file is missing or broken.
    """
    try:
        document: dict[str, Any] = read_json(read_bytes(path))
        table = np.full((len(document["tokens"]) + 1, len(document["words"])), 10.0**-DIGITS / 2)
        for row, listed in enumerate(document["table"]):
            for word, probability in listed.items():
                table[row, int(word)] = probability
        others = tuple(map(tuple, document["others"]))
    except (OSError, EOFError, ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise BadFile(path, f"expected a model as the training of the alignment writes it ({error!r})") from error
    words = {word: n for n, word in enumerate(document["words"])}
    return AlignmentModel(words, {token: n for n, token in enumerate(document["tokens"], start=1)}, table, others)


@cache
def load(language: str) -> AlignmentModel | None:
    """Return the model of a language, or None if it has none."""
    path = DATA / f"{language}.json.gz"
    return read_model(path) if path.exists() else None


def contradicts_route(text: str, language: str, route: Tokens) -> bool:
    """Return whether a navigation text fits its route too badly to be used.

    It does if it fits more than MOST_BETTER of OTHERS routes better, or the mirrored one by more than MIRRORED_BETTER.
    The bounds reject few texts with which the follower succeeds, and most texts of other routes; a text that confuses
    left and right only occasionally passes (`benchmarks/instructions/alignment.py`).
    A language without a model has no such check.
    """
    model = load(language)
    return model is not None and (model.margin(text, route) < -MIRRORED_BETTER or model.rank(text, route) > MOST_BETTER)
