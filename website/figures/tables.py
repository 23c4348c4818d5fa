"""Tables of Markdown pages, read as rows of texts."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

DIFFERENCE = re.compile(r"\**([+-]\d\.\d+) \(([+-]\d\.\d+) to ([+-]\d\.\d+)\)\**")

Row = Mapping[str, str]


def read_tables(page: Path, section: str) -> list[list[Row]]:
    """Return the tables of a section, in order; a row maps columns to cells.

    Args:
        page: the page.
        section: heading of the second level, without its marks.

    Raises:
        ValueError: if there is no such section.
    """
    text = page.read_text(encoding="utf-8")
    found = re.search(rf"^## {re.escape(section)}\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise ValueError(f"{page} has no section {section!r}")
    return [list(_rows(block)) for block in re.findall(r"(?:^\|.*\n)+", found[1], re.MULTILINE)]


def table(page: Path, section: str, first: str) -> list[Row]:
    """Return the first table of a section whose first column has a heading.

    Args:
        page: the page.
        section: heading of the second level, without its marks.
        first: heading of the first column.

    Raises:
        ValueError: if there is no such section or table.
    """
    for found in read_tables(page, section):
        if found and next(iter(found[0])) == first:
            return found
    raise ValueError(f"{page}, section {section!r}, has no table whose first column is {first!r}")


def _rows(block: str) -> Iterator[Row]:
    head, _, *lines = (_cells(line) for line in block.strip().split("\n"))
    head = [
        name if name not in head[:at] else f"{name} ({at})" for at, name in enumerate(head)
    ]  # Some are there twice.
    for line in lines:
        yield dict(zip(head, line, strict=True))


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def difference(cell: str) -> tuple[float, float, float] | None:
    """Return a difference and the bounds of its interval; None for an empty cell.

    Raises:
        ValueError: if the cell holds something else.
    """
    if not cell:
        return None
    found = DIFFERENCE.fullmatch(cell)
    if found is None:
        raise ValueError(f"the cell {cell!r} is no difference with its interval, such as '+0.1 (-0.1 to +0.3)'")
    value, low, high = map(float, found.groups())
    return value, low, high
