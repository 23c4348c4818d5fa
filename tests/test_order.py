"""The order of the tests."""

import pytest

from tests.order import slow_first

ORDERS = [
    # tests, the file of each being its letter; files with slow tests; processes; expected order
    ("a1 a2 b1 c1", "", 2, "a1 a2 b1 c1"),
    ("a1 a2 b1 c1", "c", 1, "c1 a1 a2 b1"),
    ("a1 a2 b1 b2 c1 c2 d1 d2", "bd", 2, "b1 b2 a1 a2 d1 d2 c1 c2"),
    ("a1 a2 b1 b2 c1 c2 d1 d2", "bd", 4, "b1 b2 d1 d2 a1 a2 c1 c2"),
    ("a1 a2 a3 b1 c1 c2", "a", 3, "a1 a2 a3 b1 c1 c2"),
    ("a1 b1 c1 d1 e1 f1 g1", "ceg", 2, "c1 g1 a1 e1 b1 d1 f1"),
    ("a1", "a", 4, "a1"),
    ("", "", 4, ""),
]


@pytest.mark.parametrize(("tests", "slow", "count", "expected"), ORDERS)
def test_slow_tests_begin_the_first_pieces(tests: str, slow: str, count: int, expected: str) -> None:
    assert slow_first(tests.split(), lambda name: name[0], set(slow), count) == expected.split()
