"""The paper's rule by which a text is kept or discarded (section "Data Collection"). Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum


@dataclass(frozen=True, slots=True)
class KeepRule:
    """When a text is kept; the defaults are the paper's.

    Attributes:
        verifiers: number of verifications after which a text is decided.
        min_ndtw: nDTW that a successful verification exceeds in both turns.
        min_ptc: PTC that it reaches in both turns.
        needed: number of successful verifications with which a text is kept.
    """

    verifiers: int = 3
    min_ndtw: float = 0.2
    min_ptc: float = 1.0
    needed: int = 1


@dataclass(frozen=True, slots=True)
class WalkScores:
    """Scores of one verification, by turn.

    Attributes:
        ndtw: nDTW of turn 1 and turn 2.
        ptc: PTC of turn 1 and turn 2.
    """

    ndtw: tuple[float, float]
    ptc: tuple[float, float]


class Verdict(StrEnum):
    """What the verifications so far say of a text."""

    UNDECIDED = "undecided"
    KEPT = "kept"
    DISCARDED = "discarded"


def is_success(scores: WalkScores, rule: KeepRule) -> bool:
    """Return whether a verification followed the text: nDTW above the limit and PTC at the limit, in both turns."""
    return all(one > rule.min_ndtw for one in scores.ndtw) and all(one >= rule.min_ptc for one in scores.ptc)


def verdict_on(verifications: Sequence[WalkScores], rule: KeepRule) -> Verdict:
    """Return the verdict on a text.

    As in the paper, a text is decided only after all its verifications, so that the figures of kept and discarded texts
    can be compared.

    Args:
        verifications: those that count, in any order.
        rule: the rule.
    """
    if len(verifications) < rule.verifiers:
        return Verdict.UNDECIDED
    successes = sum(is_success(scores, rule) for scores in verifications)
    return Verdict.KEPT if successes >= rule.needed else Verdict.DISCARDED
