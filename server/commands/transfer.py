"""The commands `export` and `import`: move a whole leaderboard to another host."""

import argparse
from pathlib import Path

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.runs.transfer.export import export
from arramon_server.runs.transfer.restore import import_archive


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add both commands."""
    out = commands.add_parser(
        "export", parents=[common], help="write participants, runs, steps, receipts and standings to a file"
    )
    out.add_argument(
        "file", type=Path, metavar="FILE", help="file to write, such as leaderboard.jsonl.zst; overwritten"
    )
    out.set_defaults(command=_export)

    in_ = commands.add_parser("import", parents=[common], help="import a file that `export` wrote, in one transaction")
    in_.add_argument("file", type=Path, metavar="FILE", help="file to import")
    in_.add_argument("--merge", action="store_true", help="add missing rows to a journal that already has runs")
    in_.set_defaults(command=_import)


def _export(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings, read_only=True) as database:
        rows = export(database, arguments.file)
    print(f"{arguments.file}: {rows} rows")


def _import(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings, patient=True, new=True) as database:
        imported = import_archive(database, arguments.file, merge=arguments.merge)
    print(f"{arguments.file}: {imported.added} rows added, {imported.present} already present")
