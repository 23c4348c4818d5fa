"""The commands `sheets` (briefings for writers of instructions) and `add-paraphrased` (their texts as a split)."""

import argparse
from pathlib import Path

from arramon_server.commands import Commands
from arramon_server.commands.split_description import describe_split
from arramon_server.errors import StorageError


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add both commands."""
    sheets = commands.add_parser("sheets", parents=[common], help="draw sheets for writers of instructions")
    sheets.add_argument("episodes", nargs="*", metavar="EPISODE", help="ids (default: all of the split)")
    sheets.add_argument("--split", required=True, help="split of the episodes")
    sheets.add_argument("--output", type=Path, default=Path("sheets"), help="folder (default: %(default)s)")
    sheets.set_defaults(command=_sheets)

    paraphrased = commands.add_parser(
        "add-paraphrased",
        parents=[common],
        help="add the split val_unseen_paraphrased, with free paraphrases, to the data folder",
    )
    paraphrased.set_defaults(command=_add_paraphrased)


def _sheets(arguments: argparse.Namespace) -> None:
    from arramon_dataset.paraphrases.sheet import sheets_of_split

    try:
        for path in sheets_of_split(arguments.data, arguments.split, arguments.episodes, arguments.output):
            print(path)
    except OSError as error:
        raise StorageError(f"cannot write {error.filename}: {error.strerror}") from error


def _add_paraphrased(arguments: argparse.Namespace) -> None:
    from arramon_dataset.paraphrases.collection import install

    print(describe_split(install(arguments.data)))
