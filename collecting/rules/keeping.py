"""Which texts are kept, by the paper's rule, and which a host reviews first."""

from collections.abc import Sequence
from dataclasses import dataclass

from arramon_client.world import ASSEMBLY, NAVIGATION
from arramon_collecting.settings import Settings


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a verification says of a text.

    Attributes:
        ndtw, ptc: scores of both turns.
        flagged: whether the verifier ticked any box.
    """

    ndtw: tuple[float, ...]
    ptc: tuple[float, ...]
    flagged: bool = False


KEEP, DISCARD, REVIEW = "keep", "discard", "review"
"""Decisions about a text."""


def succeeded(outcome: Outcome, settings: Settings) -> bool:
    """Return whether a verifier found the way and the places of both turns ("Data Collection" in the paper).

    That is an nDTW above `keep_ndtw` in both navigation turns, and a PTC of at least `keep_ptc` in both assembly turns.
    """
    return (
        len(outcome.ndtw) == len(outcome.ptc) == 2
        and all(score > settings.keep_ndtw for score in outcome.ndtw)
        and all(score >= settings.keep_ptc for score in outcome.ptc)
    )


def missed(outcome: Outcome, settings: Settings) -> list[tuple[int, str]]:
    """Return what a verifier did not find: turn, from 1, and phase; of a turn whose way was not found only the way."""
    found = []
    for turn, (ndtw, ptc) in enumerate(zip(outcome.ndtw, outcome.ptc, strict=True), start=1):
        if ndtw <= settings.keep_ndtw:
            found.append((turn, NAVIGATION))
        elif ptc < settings.keep_ptc:
            found.append((turn, ASSEMBLY))
    return found


def decide(outcomes: Sequence[Outcome], settings: Settings) -> str | None:
    """Return KEEP, DISCARD or REVIEW for a text; None while verifications are missing.

    Args:
        outcomes: the verifications that count.
        settings: of the collection.
    """
    if len(outcomes) < settings.verifiers:
        return None
    if sum(succeeded(one, settings) for one in outcomes) < settings.keep_needs:
        return DISCARD
    return REVIEW if sum(one.flagged for one in outcomes) >= settings.review_flags else KEEP
