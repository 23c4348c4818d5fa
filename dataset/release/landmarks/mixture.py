"""Places on which mentions agree, found as a non-parametric mixture over a grid with a background of errors.

The mixture's weights maximise the likelihood of all mentions of a kind, by expectation maximisation; where many
mentions agree, its mass gathers on few cells.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

from arramon_dataset.release.landmarks.turn_paths import Indices, Numbers

BACKGROUND = 0.15
"""Prior share of misplaced mentions."""

OTHER_COLOUR = 0.1
"""Likelihood of each colour other than the stated one."""

ROUNDED = 12
"""Decimal digits kept in each iteration, so that the result is the same on all machines."""

ITERATIONS = 60
"""Number of iterations of expectation maximisation."""

MERGED = 2.0
"""Mass within this distance belongs to one landmark, in units."""


@dataclass(frozen=True, slots=True)
class Peak:
    """A place on which mentions agree.

    Attributes:
        x, z: in units.
        votes: expected number of mentions of it.
        colours: votes by colour, of mentions that state one.
        looks: votes by look, likewise.
        languages: votes by language.
    """

    x: float
    z: float
    votes: float
    colours: tuple[tuple[str, float], ...]
    looks: tuple[tuple[str, float], ...]
    languages: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, eq=False)
class MentionsOfKind:
    """The mentions of one kind in a section.

    Attributes:
        cells: (g, 2) of (x, z), candidate places of a thing of the kind.
        likelihoods: (m, g) of each mention.
        weights: (m,), the share of its thing's one vote.
        colours: (m) stated, "" if not stated.
        looks: (m) stated, likewise.
        languages: (m) codes; may be empty.
    """

    cells: Numbers
    likelihoods: Numbers
    weights: Numbers
    colours: Sequence[str]
    looks: Sequence[str]
    languages: Sequence[str] = ()

    def subset(self, chosen: Indices) -> "MentionsOfKind":
        """Return the mentions at these indices."""
        return MentionsOfKind(
            self.cells,
            self.likelihoods[chosen],
            self.weights[chosen],
            [self.colours[int(each)] for each in chosen],
            [self.looks[int(each)] for each in chosen],
            [self.languages[int(each)] for each in chosen] if self.languages else (),
        )


def responsibilities(mentions: MentionsOfKind) -> tuple[Numbers, list[str], Numbers]:
    """Return the mixture: weights (g, c), the names of its c colours, and each mention's share in each cell (m, g)."""
    names = sorted({colour for colour in mentions.colours if colour}) or [""]
    fits = np.array([[1.0 if said in ("", name) else OTHER_COLOUR for name in names] for said in mentions.colours])
    likely, count = mentions.likelihoods, float(mentions.weights.sum())
    cells = likely.shape[1]
    mixture = np.full((cells, len(names)), 1.0 / (cells * len(names)))
    background = BACKGROUND * likely.mean(axis=1) * fits.mean(axis=1) + 1e-12
    for _ in range(ITERATIONS):
        evidence = (1.0 - BACKGROUND) * ((likely @ mixture) * fits).sum(axis=1) + background
        mixture *= likely.T @ (fits * (mentions.weights / evidence)[:, None])
        mixture *= (1.0 - BACKGROUND) / count
        mixture = (mixture / max(float(mixture.sum()), 1e-12)).round(ROUNDED)
    evidence = (1.0 - BACKGROUND) * ((likely @ mixture) * fits).sum(axis=1) + background
    shares = (1.0 - BACKGROUND) * likely * (fits @ mixture.T) / evidence[:, None] * mentions.weights[:, None]
    return mixture, names, shares


def peaks_of(mentions: MentionsOfKind, least: float) -> list[Peak]:
    """Return the places with at least so many votes, those with the most votes first."""
    if not len(mentions.weights):
        return []
    _, _, shares = responsibilities(mentions)
    votes = shares.sum(axis=0)
    tree = cKDTree(mentions.cells)
    peaks: list[Peak] = []
    neighbours = tree.sparse_distance_matrix(tree, MERGED, output_type="coo_matrix")
    close = coo_matrix((np.ones(neighbours.nnz), (neighbours.row, neighbours.col)), neighbours.shape).tocsr()
    while True:
        sums = close @ votes
        at = int(sums.argmax())
        if sums[at] < least:
            return peaks
        near = np.array(sorted(tree.query_ball_point(mentions.cells[at], MERGED)), dtype=np.intp)
        mass = votes[near] / votes[near].sum()
        x, z = mass @ mentions.cells[near]
        said = shares[:, near].sum(axis=1)
        peaks.append(
            Peak(
                float(x),
                float(z),
                float(sums[at]),
                *(
                    _by_word(said, words)
                    for words in (
                        mentions.colours,
                        mentions.looks,
                        mentions.languages or [""] * len(said),
                    )
                ),
            )
        )
        shares[:, near] = 0.0
        votes[near] = 0.0


def _by_word(votes: Numbers, words: Sequence[str]) -> tuple[tuple[str, float], ...]:
    """Return the votes for each word, the most first."""
    sums: dict[str, float] = {}
    for word, share in zip(words, votes.tolist(), strict=True):
        if word and share > 0.0:
            sums[word] = sums.get(word, 0.0) + share
    return tuple(
        sorted(((word, round(share, 2)) for word, share in sums.items()), key=lambda each: (-each[1], each[0]))
    )
