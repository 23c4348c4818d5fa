"""How much the learned reader reads exactly right of generated splits: the figures of its model card.

    python -m benchmarks.agents.reading [--data DIR] [--splits S,T] [--reader FILE]

A text's truth is what the grammar that wrote it reads in it. Rows are steps, objects and relations; a text is right if
all its rows are.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import torch

from agents.learning.reader.reader import WEIGHTS
from agents.learning.reader.task import Examples, score
from agents.learning.reader.weights import read_reader
from agents.learning.simulated.meanings import Sample, read_samples
from agents.learning.train_reader import examples_of
from lang.meaning import Navigation

SPLITS = ("val_unseen", "val_seen")
PLACES = {"street": True, "room": False}
"""What is read, and whether its meanings are navigations."""


def main() -> None:
    """Read the texts, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--splits", default=",".join(SPLITS), help="separated by commas")
    parser.add_argument("--reader", type=Path, default=WEIGHTS)
    given = parser.parse_args()
    torch.set_num_threads(1)
    print(table(given.data, given.splits.split(","), given.reader))


def table(data: Path, splits: Sequence[str], reader: Path) -> str:
    """Return a table in Markdown: for each split the shares of rows and of texts, by language, in street and room."""
    network, vocabulary = read_reader(reader)
    columns: list[str] = []
    rows: dict[str, list[str]] = {}
    for split in splits:
        samples = read_samples(data, split)
        for language in sorted({sample.language for sample in samples}):
            for place, is_street in PLACES.items():
                chosen = [each for each in samples if _is_of(each, language, is_street=is_street)]
                examples: Examples = examples_of(chosen, vocabulary)
                found = score(network, examples)[language]
                if f"{language}, {place}" not in columns:
                    columns.append(f"{language}, {place}")
                rows.setdefault(f"`{split}`, rows", []).append(f"{found.rows:.3f}")
                rows.setdefault(f"`{split}`, texts", []).append(f"{found.texts:.3f}")
    lines = [["", *columns], *([" ---"] * (len(columns) + 1),), *([name, *values] for name, values in rows.items())]
    return "\n".join(f"| {' | '.join(map(str.strip, line))} |" for line in lines)


def _is_of(sample: Sample, language: str, *, is_street: bool) -> bool:
    return sample.language == language and isinstance(sample.meaning, Navigation) == is_street


if __name__ == "__main__":
    main()
