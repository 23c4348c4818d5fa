"""The statistical check distinguishes routes, in one language."""

import pytest

from tests.benchmarks.command import numbers, printed


@pytest.mark.slow
def test_figures() -> None:
    """Most of the time goes into looking at the routes."""
    fit, contradicted = printed("benchmarks.instructions.alignment", "--lang", "en")
    shares = numbers([fit], "en paraphrases fit their own route better: mirrored")[::2]
    assert min(shares) > 0.8
    _, _, own, mirrored, other = numbers([contradicted], "en the grammar's texts contradict (more than ")
    assert own < mirrored < other
