"""The command `account`: lists, renames and bans participants' accounts, and finds duplicates of runs among them."""

import argparse
import json
import sys
from collections.abc import Sequence
from datetime import datetime
from typing import Any

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.errors import ArraMonError, Conflict
from arramon_server.runs.accounts.administration import Account, Administration

LEAST = 0.95
"""Default minimum likeness of listed pairs of runs."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    account = commands.add_parser("account", help="list, rename and ban accounts, and find runs that look alike")
    actions = account.add_subparsers(title="actions", required=True, metavar="ACTION")

    list_ = actions.add_parser("list", parents=[common], help="list all accounts, with numbers of tokens and runs")
    list_.add_argument("--json", action="store_true", help="print JSON instead of a table")
    list_.set_defaults(command=_list)

    rename = actions.add_parser(
        "rename", parents=[common], help="rename an account, with its runs; the old name stays reserved for it"
    )
    rename.add_argument("participant", metavar="PARTICIPANT", help="present name of the account")
    rename.add_argument("name", metavar="NAME", help="its new name")
    rename.set_defaults(command=_rename)

    ban = actions.add_parser(
        "ban",
        parents=[common],
        help="refuse an account's tokens, withdraw its runs from the leaderboard, and cancel its unfinished ones",
    )
    ban.add_argument("participant", metavar="PARTICIPANT", help="name of the account")
    ban.add_argument("--reason", default="", metavar="TEXT", help="reason, which the participant is shown")
    ban.set_defaults(command=_ban)

    unban = actions.add_parser(
        "unban", parents=[common], help="end a ban: tokens work again, and what it withdrew is listed again"
    )
    unban.add_argument("participant", metavar="PARTICIPANT", help="name of the account")
    unban.set_defaults(command=_unban)

    duplicates = actions.add_parser(
        "duplicates", parents=[common], help="list runs of different accounts with the same or almost the same actions"
    )
    duplicates.add_argument("--split", metavar="S", help="only runs on this split (default: all)")
    duplicates.add_argument(
        "--least",
        type=float,
        default=LEAST,
        metavar="SHARE",
        help="list pairs in which at least this share of the steps has the same action (default: %(default)s)",
    )
    duplicates.add_argument("--json", action="store_true", help="print JSON instead of a table")
    duplicates.set_defaults(command=_duplicates)


def _list(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings, read_only=True) as database:
        accounts = Administration(database).all()
    if arguments.json:
        print(json.dumps([*map(_as_json, accounts)], ensure_ascii=False, indent=1))
        return
    header = ("participant", "role", "created", "tokens", "runs", "running", "published", "banned", "earlier names")
    _print_table([header, *map(_row, accounts)])


def _rename(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings) as database:
        Administration(database).rename(arguments.participant, arguments.name)
    print(f"{arguments.participant} is now {arguments.name}; receipts that were signed before keep the old name")


def _ban(arguments: argparse.Namespace) -> None:
    from arramon_server.runs.cancellation import (
        Canceller,  # imported only here: the simulator takes half a second to load
    )

    with open_journal(arguments.settings) as database:
        withdrawn, running = Administration(database).ban(arguments.participant, arguments.reason)
        print(f"{arguments.participant} is banned: its tokens are refused, {withdrawn} runs are withdrawn", flush=True)
        canceller, open_ = Canceller(database, arguments.data), 0
        for run_id in running:
            try:
                canceller.cancel(run_id)
            except Conflict as ended:
                print(f"not cancelled: {ended}", flush=True)
            except ArraMonError as error:
                open_ += 1
                print(f"not cancelled: {run_id}: {error}", file=sys.stderr)
            else:
                print(f"cancelled: {run_id}", flush=True)
    if open_:
        raise Conflict(
            f"{arguments.participant} is banned, but {open_} of its {len(running)} unfinished runs could not be "
            "cancelled; fix the errors above, then repeat the command"
        )


def _unban(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings) as database:
        listed = Administration(database).unban(arguments.participant)
    print(f"{arguments.participant} is not banned any more: {listed} runs are listed again")


def _duplicates(arguments: argparse.Namespace) -> None:
    from arramon_server.runs.accounts.duplicates import find_duplicates  # imported only here: numpy

    header = ("split", "earlier run", "participant", "agent", "later run", "participant", "agent", "same", "likeness")
    rows, found = [header], list[dict[str, Any]]()
    with open_journal(arguments.settings, read_only=True) as database:
        for pair in find_duplicates(database, arguments.least, arguments.split):
            runs = (pair.earlier, pair.later)
            names = [name for run in runs for name in (run.run_id, run.participant, run.agent)]
            same = f"{pair.same} of {pair.episodes}"
            rows.append((pair.earlier.split, *names, same, f"{pair.likeness:.3f}"))  # type: ignore[arg-type]
            about = [
                {"run_id": run.run_id, "account": run.account, "participant": run.participant, "agent": run.agent}
                for run in runs
            ]
            numbers = {"episodes": pair.episodes, "same": pair.same, "likeness": round(pair.likeness, 6)}
            found.append({"split": pair.earlier.split, "earlier": about[0], "later": about[1], **numbers})
    if arguments.json:
        print(json.dumps(found, ensure_ascii=False, indent=1))
    elif found:
        _print_table(rows)
    else:
        print("no two runs of different accounts have that much in common", file=sys.stderr)


def _row(account: Account) -> tuple[str, ...]:
    numbers = (account.tokens, account.runs, account.running, account.published)
    banned = _time(account.banned_at) + (f" ({account.ban_reason})" if account.ban_reason else "")
    names = ", ".join(account.earlier_names) or "-"
    return (account.participant, account.role.value, _time(account.created_at), *map(str, numbers), banned, names)


def _as_json(account: Account) -> dict[str, Any]:
    return {
        "participant": account.participant,
        "role": account.role.value,
        "created_at": account.created_at.isoformat(timespec="seconds"),
        "earlier_names": list(account.earlier_names),
        "tokens": account.tokens,
        "runs": account.runs,
        "running": account.running,
        "published": account.published,
        "banned_at": account.banned_at.isoformat(timespec="seconds") if account.banned_at else None,
        "ban_reason": account.ban_reason,
    }


def _time(time: datetime | None) -> str:
    return f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-"


def _print_table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
