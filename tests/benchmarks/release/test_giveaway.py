"""What furniture reveals about the path in an imported split."""

from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_rows(release: Path) -> None:
    lines = printed("benchmarks.release.giveaway", release, "--split", "release")
    for row in ("all furniture", "named alone"):
        turns, target, chance, walker, any_place, *dense = numbers(lines, row)
        assert turns == 8
        assert all(0.0 <= share <= 1.0 for share in (target, chance, walker, any_place))
        assert dense[0] > 0.0  # The texts name furniture, which was put beside the path.
