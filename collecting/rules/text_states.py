"""Transitions between the states of a text: after a verification, and by a host's decision. Pure."""

from collections.abc import Sequence
from enum import StrEnum

from arramon_collecting.storage.records import DISCARDED, IN_REVIEW, KEPT, REJECTED, SENT_BACK, VERIFYING

from arramon_collecting.rules.text_verdict import KeepRule, Verdict, WalkScores, verdict_on
from arramon_server.errors import Conflict

LONGEST_REASON = 2000
"""Maximum characters of the reason for a decision."""


class Decision(StrEnum):
    """What a host decides on a text in review."""

    ACCEPT = "accept"
    SEND_BACK = "send_back"
    REJECT = "reject"


def state_after_verification(
    verifications: Sequence[WalkScores], flaggers: int, rule: KeepRule, review_flags: int
) -> str:
    """Return the state of a text that is being verified.

    Args:
        verifications: those that count.
        flaggers: number of their verifiers who flagged the text.
        rule: when a text is kept.
        review_flags: number of flaggers from which a host reviews a text before it is kept.
    """
    verdict = verdict_on(verifications, rule)
    if verdict is Verdict.UNDECIDED:
        return VERIFYING
    if verdict is Verdict.DISCARDED:
        return DISCARDED
    return IN_REVIEW if flaggers >= review_flags else KEPT


def state_after_decision(
    state: str, decision: Decision, verifications: Sequence[WalkScores], rule: KeepRule | None, *, has_author: bool
) -> str:
    """Return the state of a text after a host's decision.

    Args:
        state: its present state.
        decision: the decision.
        verifications: verifications of its present version that count.
        rule: when a text is kept; None where texts are reviewed but not verified.
        has_author: whether somebody can mend it.

    Raises:
        Conflict: if the text is not in review, or is sent back without an author.
    """
    if state != IN_REVIEW:
        raise Conflict(f"the text is in the state {state!r}; only texts in review are decided on")
    if decision is Decision.REJECT:
        return REJECTED
    if decision is Decision.SEND_BACK:
        if not has_author:
            raise Conflict("the text has no author to whom it could be sent back; accept or reject it")
        return SENT_BACK
    is_verified = rule is None or verdict_on(verifications, rule) is not Verdict.UNDECIDED
    return KEPT if is_verified else VERIFYING
