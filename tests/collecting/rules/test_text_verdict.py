"""The paper's rule, by a table."""

import pytest

from arramon_collecting.rules.text_verdict import KeepRule, Verdict, WalkScores, is_success, verdict_on

PAPER = KeepRule()
GOOD = WalkScores((0.21, 0.9), (1.0, 1.0))
LOST = WalkScores((0.2, 0.9), (1.0, 1.0))
MISPLACED = WalkScores((0.9, 0.9), (1.0, 0.0))


@pytest.mark.parametrize(
    ("scores", "rule", "expected"),
    [
        (GOOD, PAPER, True),
        (LOST, PAPER, False),  # "higher than 0.2"
        (WalkScores((0.9, 0.1), (1.0, 1.0)), PAPER, False),
        (MISPLACED, PAPER, False),
        (WalkScores((0.9, 0.9), (0.0, 1.0)), PAPER, False),
        (LOST, KeepRule(min_ndtw=0.1), True),
        (MISPLACED, KeepRule(min_ptc=0.0), True),
    ],
)
def test_a_verification_succeeds_in_both_turns(scores: WalkScores, rule: KeepRule, expected: bool) -> None:
    assert is_success(scores, rule) == expected


@pytest.mark.parametrize(
    ("verifications", "rule", "expected"),
    [
        ([], PAPER, Verdict.UNDECIDED),
        ([GOOD, GOOD], PAPER, Verdict.UNDECIDED),  # all three are asked, as in the paper
        ([LOST, MISPLACED, GOOD], PAPER, Verdict.KEPT),
        ([LOST, MISPLACED, LOST], PAPER, Verdict.DISCARDED),
        ([GOOD], KeepRule(verifiers=1), Verdict.KEPT),
        ([GOOD, LOST, LOST], KeepRule(needed=2), Verdict.DISCARDED),
        ([GOOD, LOST, GOOD], KeepRule(needed=2), Verdict.KEPT),
        ([LOST, LOST, LOST, GOOD], PAPER, Verdict.KEPT),  # more than asked, as a restored worker's count again
    ],
)
def test_a_text_is_decided_after_all_verifications(
    verifications: list[WalkScores], rule: KeepRule, expected: Verdict
) -> None:
    assert verdict_on(verifications, rule) is expected
