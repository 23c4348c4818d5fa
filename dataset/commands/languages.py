"""The command `language`, which checks a language's data and lists the languages."""

import argparse
from pathlib import Path

from arramon_server.commands import Commands
from arramon_server.errors import BadInput


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command with its actions."""
    language = commands.add_parser("language", help="check a language's data, or list the languages")
    actions = language.add_subparsers(title="actions", required=True, metavar="ACTION")

    check = actions.add_parser(
        "check",
        parents=[common],
        help="check the files, write every kind of meaning, and read each text back; status 1 if it does not pass",
    )
    check.add_argument("code", help="code of the language, such as te")
    check.add_argument("--seeds", type=int, default=3, metavar="N", help="texts of each meaning (default: %(default)s)")
    check.add_argument(
        "--root", type=Path, help="folder with the languages' folders (default: the installed languages)"
    )
    check.add_argument("--all", action="store_true", help="print every fault, not the first twenty of each sort")
    check.set_defaults(command=_check)

    listed = actions.add_parser("list", parents=[common], help="list the languages")
    listed.set_defaults(command=_list)


def _check(arguments: argparse.Namespace) -> int:
    from arramon_dataset.language_check import check_language

    if arguments.seeds < 1:
        raise BadInput(f"--seeds is {arguments.seeds}; expected at least 1")
    report = check_language(arguments.code, seeds=arguments.seeds, root=arguments.root)
    print(*(report.lines(None) if arguments.all else report.lines()), sep="\n")
    return int(not report.passes)


def _list(_: argparse.Namespace) -> None:
    from arramon_dataset.language_check import descriptions

    print(*descriptions(), sep="\n")
