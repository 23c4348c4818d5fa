"""Who verifies what, by tables."""

from datetime import UTC, datetime, timedelta

import pytest

from arramon_collecting.rules.verifier_choice import (
    PastWork,
    WaitingText,
    gold_episodes,
    is_gold_due,
    may_verify,
    next_text,
)

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
ME = PastWork("me", written=frozenset({"e1"}), walked=frozenset({"e2"}))


def text(text_id: str, episode_id: str, author: str | None = "ann", missing: int = 3, minutes: int = 0) -> WaitingText:
    return WaitingText(text_id, episode_id, author, missing, BEGIN + timedelta(minutes=minutes))


@pytest.mark.parametrize(
    ("waiting", "expected"),
    [
        (text("t", "e3"), True),
        (text("t", "e3", author=None), True),
        (text("t", "e3", author="me"), False),
        (text("t", "e1"), False),  # another's text of an episode that I have written for
        (text("t", "e2"), False),  # one that I have walked, be it as a known one
    ],
)
def test_nobody_verifies_what_they_know(waiting: WaitingText, expected: bool) -> None:
    assert may_verify(waiting, ME) == expected


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        ([], None),
        ([text("a", "e1"), text("b", "e2")], None),
        ([text("a", "e3", missing=0)], None),
        ([text("a", "e3", minutes=1), text("b", "e4")], "b"),
        ([text("a", "e3"), text("b", "e4", missing=1, minutes=9)], "b"),
        ([text("b", "e3"), text("a", "e4")], "a"),
    ],
)
def test_nearly_decided_texts_come_first_and_then_the_oldest(texts: list[WaitingText], expected: str | None) -> None:
    found = next_text(texts, ME)
    assert (found and found.text_id) == expected


@pytest.mark.parametrize(
    ("tasks", "golds", "share", "draw", "expected"),
    [
        (0, 0, 0.1, 0.05, True),
        (0, 0, 0.1, 0.1, False),
        (9, 0, 0.1, 0.99, True),  # the tenth at the latest
        (10, 1, 0.1, 0.09, True),
        (10, 1, 0.1, 0.11, False),
        (5, 1, 0.1, 0.0, False),  # more than its share already
        (7, 0, 0.0, 0.0, False),
    ],
)
def test_known_episodes_keep_their_share(tasks: int, golds: int, share: float, draw: float, expected: bool) -> None:
    assert is_gold_due(tasks, golds, share, draw) == expected


def test_known_episodes_are_new_to_the_worker() -> None:
    assert gold_episodes(["e1", "e2", "e3", "e4"], ME) == ["e3", "e4"]
