"""`export` and `import`: a whole leaderboard, carried to another host."""

import argparse
from contextlib import closing
from pathlib import Path

from server.commands import Commands
from server.runs.database import Database
from server.runs.exporting import export
from server.runs.importing import import_


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds both."""
    out = commands.add_parser(
        "export", parents=[common], help="write participants, runs, steps, receipts and standings to a file"
    )
    out.add_argument("file", type=Path, metavar="FILE", help="such as leaderboard.jsonl.zst; replaced if it is there")
    out.set_defaults(command=_export)

    in_ = commands.add_parser("import", parents=[common], help="bring in a file that `export` wrote, all or nothing")
    in_.add_argument("file", type=Path, metavar="FILE", help="the file")
    in_.add_argument("--merge", action="store_true", help="add what is missing to a journal that has runs already")
    in_.set_defaults(command=_import)


def _export(arguments: argparse.Namespace) -> None:
    with closing(Database(arguments.settings.journal_url, read_only=True)) as database:
        rows = export(database, arguments.file)
    print(f"{arguments.file}: {rows} rows")


def _import(arguments: argparse.Namespace) -> None:
    with closing(Database(arguments.settings.journal_url, patient=True)) as database:
        imported = import_(database, arguments.file, merge=arguments.merge)
    print(f"{arguments.file}: {imported.added} rows added, {imported.present} were there already")
