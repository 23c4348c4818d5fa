"""The command `prune`: deletes old runs that were never published."""

import argparse

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.runs.storage.pruning import PRUNABLE_STATES, PrunedRun, PruneFilter, Pruner

STATES = tuple(state.lower() for state in PRUNABLE_STATES)


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    prune = commands.add_parser(
        "prune",
        parents=[common],
        help="delete old runs that were never published; they stay counted as attempts",
        description="Delete runs that ended long ago and were never on the leaderboard, with their steps. They stay "
        "counted as attempts of their participants. Servers may be running. It cannot be undone.",
    )
    prune.add_argument(
        "--older-than", type=float, metavar="DAYS", required=True, help="only runs that ended at least so many days ago"
    )
    prune.add_argument(
        "--state", action="append", choices=STATES, help=f"only runs in this state (default: {' and '.join(STATES)})"
    )
    prune.add_argument("--split", metavar="S", help="only runs on this split")
    prune.add_argument("--participant", metavar="NAME", help="only runs shown under this name")
    prune.add_argument(
        "--with-receipts",
        action="store_true",
        help="also runs with a receipt, such as all that the client has finished; receipts that participants have stay "
        "valid, but cannot be requested or rescored from the journal any more",
    )
    prune.add_argument(
        "--compact",
        action="store_true",
        help="afterwards return the space to the file system (SQLite); servers wait meanwhile",
    )
    prune.add_argument("--dry-run", action="store_true", help="list the runs that would be deleted, and delete nothing")
    prune.set_defaults(command=_prune)


def _prune(arguments: argparse.Namespace) -> None:
    wanted = PruneFilter(
        arguments.older_than,
        tuple(state.upper() for state in arguments.state or STATES),
        arguments.split,
        arguments.participant,
        arguments.with_receipts,
    )
    number = steps = 0
    with open_journal(arguments.settings, patient=not arguments.dry_run, read_only=arguments.dry_run) as database:
        pruner = Pruner(database)
        for pruned in pruner.find(wanted) if arguments.dry_run else pruner.prune(wanted):
            print(_line(pruned), flush=True)
            number, steps = number + 1, steps + pruned.steps
        if arguments.compact and not arguments.dry_run:
            pruner.compact()
    print(f"{number} runs with {steps} steps {'would be deleted' if arguments.dry_run else 'deleted'}")


def _line(pruned: PrunedRun) -> str:
    run = pruned.run
    ended = f"{run.ended_at:%Y-%m-%d}" if run.ended_at else "-"
    whose = f"{run.agent} by {run.participant} on {run.split}"
    return f"{run.run_id}  {run.state.lower()}  {ended}  {pruned.steps} steps  {whose}"
