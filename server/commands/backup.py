"""The command `backup`: copies all files that a host cannot recreate."""

import argparse
from pathlib import Path

from arramon_server.backup import EXPORT, back_up
from arramon_server.commands import Commands
from arramon_server.configuration.sources import add_flag


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    backup = commands.add_parser(
        "backup",
        parents=[common],
        help="copy journal, secret, signing key and splits to a new folder, from which a server can be restored",
    )
    backup.add_argument("folder", type=Path, metavar="FOLDER", help="folder to create, readable by its owner only")
    add_flag(backup, "signing_key")
    backup.set_defaults(command=_backup)


def _backup(arguments: argparse.Namespace) -> None:
    names = back_up(arguments.settings, arguments.folder)
    print(f"{arguments.folder}: {', '.join(names)}")
    if EXPORT in names:
        print(f"to restore it, import {EXPORT} into an empty database")
