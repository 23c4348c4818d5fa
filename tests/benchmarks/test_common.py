"""What the benchmarks share."""

from argparse import ArgumentTypeError
from collections.abc import Callable

import pytest

from benchmarks.common import above_zero, aligned, markdown, mean_and_error, whole

ROWS = (("one", "1.0"), ("thirty", "30.25"))


def test_tables() -> None:
    assert aligned(("", "steps/s"), ROWS) == "        steps/s\none         1.0\nthirty    30.25"
    assert markdown(("", "steps/s"), ROWS) == "|  | steps/s |\n| --- | --- |\n| one | 1.0 |\n| thirty | 30.25 |"


def test_mean_and_error() -> None:
    assert mean_and_error([1.0]) == (1.0, 0.0)
    assert mean_and_error([0.0, 1.0]) == (0.5, 0.5)


@pytest.mark.parametrize("text", ["0", "-1", "1.5", "x", ""])
def test_no_whole_number(text: str) -> None:
    with pytest.raises(ArgumentTypeError, match="is no whole number above 0"):
        whole(text)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "x"])
def test_no_duration(text: str) -> None:
    with pytest.raises(ArgumentTypeError, match="is no number above 0"):
        above_zero(text)


@pytest.mark.parametrize(("read", "text", "value"), [(whole, "12", 12), (above_zero, "0.5", 0.5)])
def test_numbers(read: Callable[[str], float], text: str, value: float) -> None:
    assert read(text) == value
