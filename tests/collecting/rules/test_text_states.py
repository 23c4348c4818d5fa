"""States of texts, by tables."""

import pytest

from arramon_collecting.rules.text_states import Decision, state_after_decision, state_after_verification
from arramon_collecting.rules.text_verdict import KeepRule, WalkScores
from arramon_server.errors import Conflict

RULE = KeepRule()
GOOD, BAD = WalkScores((0.9, 0.9), (1.0, 1.0)), WalkScores((0.9, 0.9), (1.0, 0.0))


@pytest.mark.parametrize(
    ("verifications", "flaggers", "expected"),
    [
        ([], 0, "verifying"),
        ([GOOD, GOOD], 2, "verifying"),
        ([GOOD, BAD, BAD], 0, "kept"),
        ([GOOD, BAD, BAD], 1, "kept"),
        ([GOOD, BAD, BAD], 2, "in_review"),
        ([BAD, BAD, BAD], 3, "discarded"),
    ],
)
def test_after_a_verification(verifications: list[WalkScores], flaggers: int, expected: str) -> None:
    assert state_after_verification(verifications, flaggers, RULE, 2) == expected


@pytest.mark.parametrize(
    ("decision", "verifications", "rule", "expected"),
    [
        (Decision.ACCEPT, [], RULE, "verifying"),  # a soft check brought it here
        (Decision.ACCEPT, [GOOD, BAD, BAD], RULE, "kept"),  # flags brought it here
        (Decision.ACCEPT, [], None, "kept"),  # a generated text
        (Decision.SEND_BACK, [], RULE, "sent_back"),
        (Decision.REJECT, [GOOD, BAD, BAD], RULE, "rejected"),
    ],
)
def test_after_a_decision(
    decision: Decision, verifications: list[WalkScores], rule: KeepRule | None, expected: str
) -> None:
    assert state_after_decision("in_review", decision, verifications, rule, has_author=True) == expected


@pytest.mark.parametrize("state", ["verifying", "kept", "discarded", "sent_back", "rejected", "withdrawn"])
def test_only_texts_in_review_are_decided_on(state: str) -> None:
    with pytest.raises(Conflict, match="only texts in review"):
        state_after_decision(state, Decision.ACCEPT, [], RULE, has_author=True)


def test_nobody_can_mend_a_text_without_author() -> None:
    with pytest.raises(Conflict, match="no author"):
        state_after_decision("in_review", Decision.SEND_BACK, [], RULE, has_author=False)
