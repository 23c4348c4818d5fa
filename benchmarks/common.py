"""Command-line options, data folders and tables that the benchmarks share."""

import argparse
import json
import math
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from arramon_client import Agent, load_agent
from arramon_client.errors import AgentLoadError
from arramon_dataset.release.importer import import_release
from arramon_server.episodes.splits import Split, read_splits

SAMPLE = Path(__file__).parents[1] / "examples" / "sample" / "sample.json"


class OpenGround:
    """A collision check without obstacles, for ground-truth paths, which never collide."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:  # noqa: ARG002
        """Return True."""
        return True


def parser_of(doc: str | None) -> argparse.ArgumentParser:
    """Return the argument parser of a benchmark; its help is the module's docstring."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def named_agent(name: str, arguments: Mapping[str, object] = MappingProxyType({})) -> Agent:
    """Return the agent that a command-line option names.

    Raises:
        SystemExit: if it cannot be loaded; the message says why.
    """
    try:
        return load_agent(name, arguments)
    except AgentLoadError as error:
        raise SystemExit(str(error)) from error


def add_data(parser: argparse.ArgumentParser) -> None:
    """Add the option `--data`, a data folder to use instead of the sample episodes."""
    parser.add_argument("--data", type=Path, metavar="DIR", help="data folder (default: the sample episodes)")


def add_rounds(parser: argparse.ArgumentParser, default: int) -> None:
    """Add the option `--rounds`, the number of repetitions of all measurements."""
    parser.add_argument(
        "--rounds", type=positive_int, default=default, metavar="N", help="number of rounds (default: %(default)s)"
    )


def add_seconds(parser: argparse.ArgumentParser, default: float, what: str) -> None:
    """Add the option `--seconds`, the duration of each measurement."""
    parser.add_argument(
        "--seconds",
        type=positive_float,
        default=default,
        metavar="S",
        help=f"{what} in seconds (default: %(default)s)",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option `--json`, an output file for all results."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="output file for the results")


def write_json(path: Path | None, results: object) -> None:
    """Write results to the file that `--json` names, if any."""
    if path is not None:
        path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def positive_int(text: str) -> int:
    """Parse a positive integer, for argparse.

    Raises:
        argparse.ArgumentTypeError: if it is anything else.
    """
    if not text.isascii() or not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number above 0")
    return int(text)


def positive_float(text: str) -> float:
    """Parse a positive number, for argparse.

    Raises:
        argparse.ArgumentTypeError: if it is anything else.
    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return number


@contextmanager
def data_or_sample(data: Path | None) -> Iterator[Path]:
    """Yield the given data folder, or a temporary one with the sample episodes."""
    if data is not None:
        yield data
        return
    with tempfile.TemporaryDirectory() as folder:
        import_release([SAMPLE], Path(folder))
        yield Path(folder)


def largest_split(data: Path) -> Split:
    """Return the split of a data folder that has the most episodes."""
    return max(read_splits(data).values(), key=lambda split: len(split.episodes))


def mean_and_error(values: Sequence[float]) -> tuple[float, float]:
    """Return the mean of values and its standard error."""
    average = sum(values) / len(values)
    spread = sum((value - average) ** 2 for value in values) / max(1, len(values) - 1)
    return average, math.sqrt(spread / len(values))


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table for a terminal, with the first column left-aligned and the others right-aligned."""
    lines = [header, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]).rstrip() for line in lines
    )


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
