"""The command `token`: creates, lists and revokes participants' tokens."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.runs.accounts.accounts import AccessToken, Accounts
from arramon_server.runs.accounts.callers import Role


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    token = commands.add_parser("token", help="create, list and revoke participants' tokens")
    actions = token.add_subparsers(title="actions", required=True, metavar="ACTION")

    create = actions.add_parser("create", parents=[common], help="create a token and print it, only this once")
    create.add_argument("participant", metavar="PARTICIPANT", help="name of the participant; created if new")
    roles = tuple(role.value for role in (Role.PARTICIPANT, Role.HOST))
    create.add_argument(
        "--role", default=roles[0], choices=roles, help="role; a host sees all runs (default: %(default)s)"
    )
    create.add_argument("--expires", type=float, metavar="DAYS", help="days until it expires (default: never)")
    create.add_argument("--note", default="", metavar="TEXT", help="note for the host, such as the token's recipient")
    create.set_defaults(command=_create)

    list_ = actions.add_parser("list", parents=[common], help="list all tokens, without their secrets")
    list_.set_defaults(command=_list)

    revoke = actions.add_parser("revoke", parents=[common], help="revoke a token; takes effect within seconds")
    revoke.add_argument("token_id", metavar="ID", help="id of the token, as listed; also its second part")
    revoke.set_defaults(command=_revoke)


def _create(arguments: argparse.Namespace) -> None:
    with _accounts(arguments) as accounts:
        token = accounts.create_token(
            arguments.participant, Role(arguments.role), days=arguments.expires, note=arguments.note
        )
    print(
        f"token for {arguments.participant} ({arguments.role}); keep it safe, it is shown only once:", file=sys.stderr
    )
    print(token)


def _list(arguments: argparse.Namespace) -> None:
    with _accounts(arguments) as accounts:
        rows = [("id", "participant", "role", "created", "expires", "revoked", "note"), *map(_row, accounts.tokens())]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _revoke(arguments: argparse.Namespace) -> None:
    with _accounts(arguments) as accounts:
        token = accounts.revoke(arguments.token_id)
    print(f"token {token.token_id} of {token.participant} is revoked")


def _row(token: AccessToken) -> tuple[str, ...]:
    times = (_time(time) for time in (token.created_at, token.expires_at, token.revoked_at))
    return (token.token_id, token.participant, token.role.value, *times, token.note or "-")


def _time(time: datetime | None) -> str:
    return f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-"


@contextmanager
def _accounts(arguments: argparse.Namespace) -> Iterator[Accounts]:
    with open_journal(arguments.settings) as database:
        yield Accounts(database)
