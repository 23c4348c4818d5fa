"""Exact-match accuracy of the learned reader on generated splits: the figures of its model card.

    python -m benchmarks.agents.reading [--data DIR] [--splits S,T] [--reader FILE]

The reference is the meaning that the grammar reads in its own text. Rows are steps, objects and relations; a text is
right if all its rows are right.
"""

from collections.abc import Sequence
from pathlib import Path

import torch

from arramon_agents.reading.reader.reader import WEIGHTS, read_reader
from arramon_agents.reading.reader.task import score
from arramon_agents.reading.reader.train import examples_of
from arramon_agents.simulated.meanings import read_samples
from arramon_lang.meaning import Assembly, Navigation
from benchmarks.common import markdown_table, parser_of

SPLITS = ("val_unseen", "val_seen")
PLACES = {"street": Navigation, "room": Assembly}
"""Type of the meanings of instructions in street and room."""


def main() -> None:
    """Read the texts, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--splits", default=",".join(SPLITS), help="separated by commas")
    parser.add_argument("--reader", type=Path, default=WEIGHTS)
    given = parser.parse_args()
    torch.set_num_threads(1)
    print(table(given.data, given.splits.split(","), given.reader))


def table(data: Path, splits: Sequence[str], reader: Path) -> str:
    """Return a table in Markdown: for each split the shares of rows and of texts, by language, in street and room."""
    network, vocabulary = read_reader(reader)
    shares: dict[tuple[str, str], dict[tuple[str, str], str]] = {}
    for split in splits:
        samples = read_samples(data, split)
        for place, kind in PLACES.items():
            examples = examples_of([sample for sample in samples if isinstance(sample.meaning, kind)], vocabulary)
            for language, found in score(network, examples).items():
                for what, value in (("rows", found.rows), ("texts", found.texts)):
                    shares.setdefault((split, what), {})[language, place] = f"{value:.3f}"
    languages = sorted({language for row in shares.values() for language, _ in row})
    columns = [(language, place) for language in languages for place in PLACES]
    rows = [[f"`{split}`, {what}", *(row.get(each, "") for each in columns)] for (split, what), row in shares.items()]
    return markdown_table(["", *map(", ".join, columns)], rows)


if __name__ == "__main__":
    main()
