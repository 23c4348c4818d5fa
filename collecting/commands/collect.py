"""The command `collect`: creates, describes, pauses and exports collections of instructions."""

import argparse

from arramon_collecting.storage.records import CLOSED, PAUSED, RUNNING
from arramon_collecting.storage.store import Store
from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command with its actions."""
    collect = commands.add_parser("collect", help="collect instructions from people, or let them review generated ones")
    actions = collect.add_subparsers(title="actions", required=True, metavar="ACTION")
    for name, state, meaning in (
        ("pause", PAUSED, "give out no more tasks; open ones can be submitted"),
        ("resume", RUNNING, "give out tasks again"),
        ("close", CLOSED, "give out no more tasks, for good"),
    ):
        action = actions.add_parser(name, parents=[common], help=meaning)
        action.add_argument("name", metavar="NAME", help="the collection")
        action.set_defaults(command=_set_state, state=state)


def _set_state(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings) as database:
        changed = Store(database).collections.set_state(arguments.name, arguments.state)
    print(f"collection {changed.name} is {changed.state}")
