"""The paper's rule: a text is kept if one verifier has nDTW above 0.2 in both turns, and PTC 1 in both."""

import pytest

from arramon_collecting.rules.keeping import DISCARD, KEEP, REVIEW, Outcome, decide, missed
from arramon_collecting.settings import Settings

GOOD = Outcome((0.21, 0.9), (1.0, 1.0))
AT_THE_LIMIT = Outcome((0.2, 0.9), (1.0, 1.0))
WRONG_CELL = Outcome((0.9, 0.9), (1.0, 0.0))
GAVE_UP = Outcome((0.9,), (1.0,))
FLAGGED = Outcome((0.9, 0.9), (1.0, 1.0), flagged=True)


@pytest.mark.parametrize(
    ("outcomes", "expected"),
    [
        ([GOOD, WRONG_CELL], None),
        ([GOOD, WRONG_CELL, WRONG_CELL], KEEP),
        ([AT_THE_LIMIT, AT_THE_LIMIT, AT_THE_LIMIT], DISCARD),
        ([GAVE_UP, WRONG_CELL, AT_THE_LIMIT], DISCARD),
        ([FLAGGED, GOOD, GOOD], KEEP),
        ([FLAGGED, FLAGGED, GOOD], REVIEW),
    ],
)
def test_the_rule(outcomes: list[Outcome], expected: str | None) -> None:
    assert decide(outcomes, Settings()) == expected


def test_the_rule_is_a_setting() -> None:
    settings = Settings(verifiers=2, keep_needs=2, keep_ndtw=0.5, review_flags=3)
    assert decide([FLAGGED, FLAGGED], settings) == KEEP
    assert decide([FLAGGED, GOOD], settings) == DISCARD


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        (GOOD, []),
        (AT_THE_LIMIT, [(1, "navigation")]),
        (WRONG_CELL, [(2, "assembly")]),
        (Outcome((0.1, 0.1), (0.0, 1.0)), [(1, "navigation"), (2, "navigation")]),
    ],
)
def test_what_was_not_found(outcome: Outcome, expected: list[tuple[int, str]]) -> None:
    assert missed(outcome, Settings()) == expected
