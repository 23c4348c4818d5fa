"""Lengths of instructions, paths and action sequences."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from arramon_server.episodes.episode import Episode, Turn

MEASURES = ("words", "path", "actions")
"""Measures of each phase of a turn: words of the instruction; positions (points or cells) of the ground truth, the
first included; its actions, the pick-up or placement included."""


@dataclass(frozen=True, eq=False)
class Lengths:
    """The distribution of one measure.

    Attributes:
        mean: mean length.
        longest: maximum length.
        counts: number of occurrences, by length.
    """

    mean: float
    longest: int
    counts: dict[int, int]

    @classmethod
    def of(cls, values: Iterable[int]) -> "Lengths":
        """Return the distribution of at least one value."""
        counts = Counter(values)
        mean = sum(value * count for value, count in counts.items()) / counts.total()
        return cls(mean, max(counts), dict(sorted(counts.items())))


@dataclass(frozen=True, eq=False)
class PhaseLengths:
    """Length distributions of one phase.

    Attributes:
        turns: lengths of single turns, by measure.
        episodes: sums over an episode's two turns, as in the paper's table, by measure.
    """

    turns: dict[str, Lengths]
    episodes: dict[str, Lengths]


def lengths_of(episodes: Sequence[Episode], phase: str, texts: Sequence[Sequence[str]]) -> PhaseLengths:
    """Measure the lengths in a phase of episodes.

    Args:
        episodes: at least one.
        phase: "navigation" or "assembly".
        texts: the words of each instruction, two for each episode, in order.
    """
    turns: dict[str, Lengths] = {}
    sums: dict[str, Lengths] = {}
    truths = [_truth(turn, phase) for episode in episodes for turn in episode.turns]
    for name, values in (
        ("words", [len(words) for words in texts]),
        ("path", [path for path, _ in truths]),
        ("actions", [actions for _, actions in truths]),
    ):
        turns[name] = Lengths.of(values)
        sums[name] = Lengths.of(first + second for first, second in zip(values[::2], values[1::2], strict=True))
    return PhaseLengths(turns, sums)


def _truth(turn: Turn, phase: str) -> tuple[int, int]:
    if phase == "navigation":
        return len(turn.path), len(turn.actions)
    return len(turn.room_path), len(turn.room_actions)
