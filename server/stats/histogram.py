"""The classes into which lengths are sorted, for text and pictures alike."""

from server.stats.lengths import Lengths

BINS: dict[tuple[str, str], tuple[int, int]] = {
    ("navigation", "words"): (5, 125),
    ("navigation", "path"): (5, 125),
    ("assembly", "words"): (5, 125),
    ("assembly", "path"): (1, 10),
}
"""For a phase and a measure: the width of a class, and from where on all go into the last one (125 as in the paper)."""


def binned(lengths: Lengths, width: int, stop: int) -> list[float]:
    """The share of each class, 0 to 1: of `width` each, and a last one from `stop` on."""
    shares = [0.0] * (stop // width + 1)
    total = sum(lengths.counts.values())
    for length, count in lengths.counts.items():
        shares[min(length, stop) // width] += count / total
    return shares
