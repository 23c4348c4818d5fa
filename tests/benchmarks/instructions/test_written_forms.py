"""Reader and follower on texts written by hand."""

from collections import Counter

from benchmarks.instructions.written_forms import written_episodes
from tests.benchmarks.command import printed


def test_halves_are_of_five_episodes_each() -> None:
    halves = Counter((each.half, each.episode.episode_id) for each in written_episodes())
    assert set(halves.values()) == {2}
    assert Counter(half for half, _ in halves) == {"development": 5, "test": 5}


def test_the_development_half_is_read() -> None:
    lines = printed("benchmarks.instructions.written_forms", "--no-play")
    form, turns, target, cell, _ = lines[-1].split()
    assert (form, turns) == ("all", "20")
    assert float(target) >= 0.9
    assert float(cell) >= 0.9
