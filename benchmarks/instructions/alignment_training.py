"""Training of the word alignment model (`dataset/alignment`), by expectation maximisation."""

import gzip
import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from arramon_dataset.alignment.model import DIGITS, AlignmentModel, posteriors, words_of
from arramon_dataset.alignment.route_tokens import Tokens

ITERATIONS, SMOOTHING = 8, 0.02
"""Iterations of training; smoothing added to each expected count."""

MIN_COUNT = 2
"""Least number of occurrences of a word in training; rarer words are ignored."""


def learn(pairs: Iterable[tuple[str, Tokens]], others: int) -> AlignmentModel:
    """Train a model on texts with their routes; `others` of the routes are kept for comparison."""
    listed = [(words_of(text), route) for text, route in pairs]
    counts = Counter(word for words, _ in listed for word in words)
    words = {word: n for n, word in enumerate(sorted(word for word in counts if counts[word] >= MIN_COUNT))}
    tokens = {token: n for n, token in enumerate(sorted({token for _, route in listed for token in route}), start=1)}
    table = np.full((len(tokens) + 1, len(words)), 1.0 / len(words))
    indexed = [
        ([words[word] for word in said if word in words], [tokens[token] for token in route]) for said, route in listed
    ]
    for _ in range(ITERATIONS):
        expected = np.full_like(table, SMOOTHING)
        for known, rows in indexed:
            parts = posteriors(table, known, rows)
            parts /= parts.sum(axis=1, keepdims=True)
            np.add.at(expected, (np.array([0, *rows])[None, :], np.array(known)[:, None]), parts)
        table = expected / expected.sum(axis=1, keepdims=True)
    step = max(1, len(listed) // others)
    return AlignmentModel(words, tokens, table, tuple(route for _, route in listed[::step])[:others])


def save(model: AlignmentModel, path: Path) -> None:
    """Write a model, the same bytes for the same model."""
    rows = [{str(n): round(float(p), DIGITS) for n, p in enumerate(row) if p >= 10.0**-DIGITS} for row in model.table]
    document = {"words": list(model.words), "tokens": list(model.tokens), "table": rows, "others": model.others}
    path.write_bytes(gzip.compress(json.dumps(document, ensure_ascii=False).encode(), mtime=0))
