"""Histogram bins for lengths, shared by tables and plots."""

from arramon_dataset.statistics.lengths import Lengths

BINS: dict[tuple[str, str], tuple[int, int]] = {
    ("navigation", "words"): (5, 125),
    ("navigation", "path"): (5, 125),
    ("assembly", "words"): (5, 125),
    ("assembly", "path"): (1, 10),
}
"""Width of a bin, and start of the last, open bin, by phase and measure (125 as in the paper)."""


def bin_shares(lengths: Lengths, width: int, stop: int) -> list[float]:
    """Return the share of lengths in each bin, 0 to 1: bins of `width`, and a last one from `stop` on."""
    shares = [0.0] * (stop // width + 1)
    total = sum(lengths.counts.values())
    for length, count in lengths.counts.items():
        shares[min(length, stop) // width] += count / total
    return shares
