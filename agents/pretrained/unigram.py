"""Tokenization by a unigram model: the most likely segmentation of a text, as in SentencePiece."""

import re
from collections.abc import Mapping, Sequence

SPACE = "\u2581"
"""Character for a space in pieces."""

_UNKNOWN_PENALTY = 10.0
"""Difference between the log probabilities of the least likely piece and of an unknown character."""


class Unigram:
    """Segments texts into pieces.

    Args:
        pieces: pieces by id.
        scores: log probability of each piece.
        unknown: id of characters that are in no piece.
        replaced: character normalisation, as a table for `str.translate`.
    """

    def __init__(
        self, pieces: Sequence[str], scores: Sequence[float], unknown: int, replaced: Mapping[int, str]
    ) -> None:
        self._known = {
            piece: (number, score)
            for number, (piece, score) in enumerate(zip(pieces, scores, strict=True))
            if number != unknown
        }
        self._longest = max(map(len, self._known))
        self._unknown = unknown, min(scores) - _UNKNOWN_PENALTY
        self._replaced = dict(replaced)

    def encode(self, text: str) -> list[int]:
        """Return the ids of a text's pieces."""
        spaced = re.sub(" {2,}", " ", text.translate(self._replaced))
        marked = (spaced if spaced.startswith(" ") else f" {spaced}").replace(" ", SPACE)
        best = [0.0] + [float("-inf")] * len(marked)  # of each prefix
        last = [(0, 0)] * (len(marked) + 1)  # number and start of its last piece
        for start in range(len(marked)):
            for end in range(start + 1, min(start + self._longest, len(marked)) + 1):
                found = self._known.get(marked[start:end])
                if found and best[start] + found[1] > best[end]:
                    best[end], last[end] = best[start] + found[1], (found[0], start)
            if best[start] + self._unknown[1] > best[start + 1]:
                best[start + 1], last[start + 1] = best[start] + self._unknown[1], (self._unknown[0], start)
        numbers, end = [], len(marked)
        while end:
            number, end = last[end]
            numbers.append(number)
        return numbers[::-1]
