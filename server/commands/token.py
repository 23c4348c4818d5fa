"""`token` and `quota`: who may play, and how much."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import datetime

from server.commands import Commands
from server.runs.accounts import Accounts, Token
from server.runs.callers import Role
from server.runs.database import Database


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds both."""
    token = commands.add_parser("token", help="make, list and revoke the tokens of participants")
    actions = token.add_subparsers(title="actions", required=True, metavar="ACTION")

    create = actions.add_parser("create", parents=[common], help="make a token, and print it this once")
    create.add_argument("participant", metavar="PARTICIPANT", help="the name; made where there is none yet")
    roles = tuple(role.value for role in (Role.PARTICIPANT, Role.HOST))
    create.add_argument("--role", default=roles[0], choices=roles, help="a host sees all runs (default: %(default)s)")
    create.add_argument("--expires", type=float, metavar="DAYS", help="days for which it is good (default: for ever)")
    create.add_argument("--note", default="", metavar="TEXT", help="for yourself, such as whom you sent it to")
    create.set_defaults(command=_create)

    list_ = actions.add_parser("list", parents=[common], help="what is known of each token; none is shown itself")
    list_.set_defaults(command=_list)

    revoke = actions.add_parser("revoke", parents=[common], help="make a token good for nothing, within seconds")
    revoke.add_argument("token_id", metavar="ID", help="as `token list` shows it; the second part of the token")
    revoke.set_defaults(command=_revoke)


def _create(arguments: argparse.Namespace) -> None:
    with _accounts(arguments) as accounts:
        token = accounts.create_token(
            arguments.participant, Role(arguments.role), days=arguments.expires, note=arguments.note
        )
    print(f"{arguments.participant} ({arguments.role}); keep it safe, it is shown this once:", file=sys.stderr)
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


def _row(token: Token) -> tuple[str, ...]:
    times = (_time(time) for time in (token.created_at, token.expires_at, token.revoked_at))
    return (token.token_id, token.participant, token.role.value, *times, token.note or "-")


def _time(time: datetime | None) -> str:
    return f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-"


@contextmanager
def _accounts(arguments: argparse.Namespace) -> Iterator[Accounts]:
    with closing(Database(arguments.settings.journal_url)) as database:
        yield Accounts(database)
