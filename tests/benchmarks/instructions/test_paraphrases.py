"""Accuracy of reader and follower on the free paraphrases."""

from tests.benchmarks.command import numbers, printed

MODULE = "benchmarks.instructions.paraphrases"


def test_reading_and_playing() -> None:
    lines = printed(MODULE, "--lang", "en", "--play", 1)
    for row, count in (("the target is named right", 312), ("whole meaning of assembly", 40)):
        share, number, *_ = numbers(lines, f"en {row}:")
        assert (number, 0.5 < share <= 1.0) == (count, True)
    for played in ("paraphrases", "the grammar's texts"):
        assert numbers(lines, f"en follower with {played}, ")[0] == 1


def test_batches() -> None:
    lines = printed(MODULE, "--lang", "hi", "--batches")
    assert len(lines) == 12
    for batch in range(1, 7):
        share, number, *_ = numbers(lines, f"hi batch {batch}, whole meaning of navigation:")
        assert (number, 0.5 < share <= 1.0) == (40, True)
