"""The screening test: attempts, pauses, and that each language has all questions."""

from datetime import UTC, datetime, timedelta

import pytest

from arramon_collecting.rules.screening import CHOICES, RIGHT_WRITE, Screening, wrong_answers

NOW = datetime(2026, 5, 4, 12, tzinfo=UTC)
PAUSE = timedelta(minutes=60)


def after(*attempts: tuple[float, bool]) -> Screening:
    """How a worker stands after attempts, each at minutes after NOW, right or not."""
    found = Screening()
    for minutes, is_right in attempts:
        at = NOW + timedelta(minutes=minutes)
        found = found.answered(is_right=is_right, now=at, attempts=2, pause=PAUSE)
    return found


@pytest.mark.parametrize(
    ("attempts", "passed", "failed", "paused"),
    [
        ((), False, 0, False),
        (((0, True),), True, 0, False),
        (((0, False),), False, 1, False),
        (((0, False), (1, True)), True, 1, False),
        (((0, False), (1, False)), False, 0, True),
        (((0, False), (1, False), (2, True)), False, 0, True),  # in the pause nothing counts
        (((0, False), (1, False), (62, True)), True, 0, False),
        (((0, False), (1, False), (62, False)), False, 1, False),
        (((0, True), (1, False)), True, 0, False),
    ],
)
def test_attempts(attempts: tuple[tuple[float, bool], ...], passed: bool, failed: int, paused: bool) -> None:
    found = after(*attempts)
    last = NOW + timedelta(minutes=attempts[-1][0] if attempts else 0)
    assert (found.passed_at is not None, found.attempts, found.is_paused(last)) == (passed, failed, paused)
    assert Screening.stored(found.as_stored()) == found


def test_a_pause_ends() -> None:
    paused = after((0, False), (1, False))
    assert paused.until == NOW + timedelta(minutes=61)
    assert [paused.is_paused(NOW + timedelta(minutes=minutes)) for minutes in (60, 61)] == [True, False]


@pytest.mark.parametrize(
    ("answers", "wrong"),
    [
        (RIGHT_WRITE, ()),
        ({}, tuple(RIGHT_WRITE)),
        ({**RIGHT_WRITE, "q2": "b"}, ("q2",)),
        ({"q1": "z"}, tuple(RIGHT_WRITE)),
    ],
)
def test_wrong_answers(answers: dict[str, str], wrong: tuple[str, ...]) -> None:
    assert wrong_answers(answers, RIGHT_WRITE) == wrong


def test_right_answers_are_choices() -> None:
    assert set(RIGHT_WRITE.values()) <= set(CHOICES)
