"""Who gets which task: nobody a map that they know, and no map two texts."""

from itertools import pairwise

import pytest

from arramon_collecting.rules.assignment import (
    Candidate,
    Known,
    next_gold,
    next_to_verify,
    next_to_write,
    wants_gold,
)

NOTHING = Known()


@pytest.mark.parametrize(
    ("taken", "known", "expected"),
    [
        (set(), NOTHING, "a"),
        ({"a"}, NOTHING, "b"),
        ({"a"}, Known(written=frozenset("b")), "c"),
        ({"a"}, Known(verified=frozenset("b")), "c"),
        ({"a", "b", "c"}, NOTHING, None),
        (set(), Known(written=frozenset("ab"), verified=frozenset("c")), None),
    ],
)
def test_the_next_episode_to_write_for(taken: set[str], known: Known, expected: str | None) -> None:
    assert next_to_write("abc", taken, known) == expected


def text(name: str, author: str = "ann", verifiers: str = "") -> Candidate:
    return Candidate(name, f"episode-{name}", author, frozenset(verifiers))


@pytest.mark.parametrize(
    ("texts", "known", "expected"),
    [
        ([text("1"), text("2")], NOTHING, "1"),
        ([text("1"), text("2", verifiers="xy")], NOTHING, "2"),
        ([text("1"), text("2", verifiers="xyz")], NOTHING, "1"),
        ([text("1", author="me"), text("2")], NOTHING, "2"),
        ([text("1"), text("2")], Known(written=frozenset({"episode-1"})), "2"),
        ([text("1"), text("2")], Known(verified=frozenset({"episode-1"})), "2"),
        ([text("1", author="me")], NOTHING, None),
        ([], NOTHING, None),
    ],
)
def test_the_next_text_to_verify(texts: list[Candidate], known: Known, expected: str | None) -> None:
    found = next_to_verify(texts, "me", known, 3)
    assert (found and found.text_id) == expected


def test_golds_keep_their_share_and_come_at_no_fixed_place() -> None:
    draws = [((n * 7919) % 1000) / 1000 for n in range(2000)]
    golds, places = 0, []
    for number, draw in enumerate(draws):
        if wants_gold(number, golds, 0.1, draw):
            golds += 1
            places.append(number)
    assert 180 <= golds <= 220
    gaps = {after - before for before, after in pairwise(places)}
    assert len(gaps) > 5
    assert not any(wants_gold(number, 0, 0.0, 0.0) for number in range(100))


def test_a_gold_is_one_that_the_worker_has_not_seen() -> None:
    known = Known(verified=frozenset("a"))
    assert [next_gold("abc", known, draw) for draw in (0.0, 0.49, 0.5, 0.999)] == ["b", "b", "c", "c"]
    assert next_gold("a", known, 0.5) is None
