"""The order of the tests, in which slow ones start first in the processes of pytest-xdist."""

from collections.abc import Callable, Collection, Hashable, Sequence
from typing import TypeVar

Item = TypeVar("Item")

SLOW_PROCESSES = 2
"""Number of processes that begin with slow tests. They start many processes of their own, so that more would crowd."""


def slow_first(
    items: Sequence[Item], file_of: Callable[[Item], Hashable], slow: Collection[Hashable], count: int
) -> list[Item]:
    """Return tests in an order in which slow ones start first.

    `--dist worksteal` gives each process one of `count` equal pieces of the tests in order, and moves tests from the
    end of the longest piece to a process that has none left. So the first pieces begin with the files that hold slow
    tests, in turn, and the last tests of each piece are quick.

    Args:
        items: the tests, those of a file in a row.
        file_of: returns the file of a test.
        slow: files with slow tests.
        count: number of processes.
    """
    groups: dict[Hashable, list[Item]] = {}
    for item in items:
        if file_of(item) in slow:
            groups.setdefault(file_of(item), []).append(item)
    quick = [item for item in items if file_of(item) not in slow]
    starts: list[list[Item]] = [[] for _ in range(min(SLOW_PROCESSES, count))]
    for number, group in enumerate(groups.values()):
        starts[number % len(starts)] += group
    ordered, left = [], len(items)
    for number in range(count):
        size = left // (count - number)
        left -= size
        start = starts[number] if number < len(starts) else []
        filling = max(size - len(start), 0)
        ordered += start + quick[:filling]
        quick = quick[filling:]
    return ordered + quick
