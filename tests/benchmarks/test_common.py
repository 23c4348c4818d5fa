"""What the benchmarks share."""

from argparse import ArgumentTypeError
from collections.abc import Callable

import pytest

from benchmarks.common import markdown_table, mean_and_error, positive_float, positive_int, text_table

ROWS = (("one", "1.0"), ("thirty", "30.25"))


def test_tables() -> None:
    assert text_table(("", "steps/s"), ROWS) == "        steps/s\none         1.0\nthirty    30.25"
    assert markdown_table(("", "steps/s"), ROWS) == "|  | steps/s |\n| --- | --- |\n| one | 1.0 |\n| thirty | 30.25 |"


def test_mean_and_error() -> None:
    assert mean_and_error([1.0]) == (1.0, 0.0)
    assert mean_and_error([0.0, 1.0]) == (0.5, 0.5)


@pytest.mark.parametrize("text", ["0", "-1", "1.5", "x", ""])
def test_no_whole_number(text: str) -> None:
    with pytest.raises(ArgumentTypeError, match="is no whole number above 0"):
        positive_int(text)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "x"])
def test_no_duration(text: str) -> None:
    with pytest.raises(ArgumentTypeError, match="is no number above 0"):
        positive_float(text)


@pytest.mark.parametrize(("read", "text", "value"), [(positive_int, "12", 12), (positive_float, "0.5", 0.5)])
def test_numbers(read: Callable[[str], float], text: str, value: float) -> None:
    assert read(text) == value
