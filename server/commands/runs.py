"""The command `runs`: lists and cancels runs for the host."""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.errors import BadInput
from arramon_server.runs.storage.records import CANCELLED, COMPLETE, RUNNING
from arramon_server.runs.storage.run_listing import RunFilter, RunSummary, find_runs

STATES = tuple(state.lower() for state in (RUNNING, COMPLETE, CANCELLED))

LIMIT = 50
"""Default maximum number of listed runs."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    runs = commands.add_parser(
        "runs",
        parents=[common],
        help="list runs, the latest first, or cancel some; possible while servers are running",
        usage="arramon-server runs [options] (list | cancel RUN ...)",
    )
    runs.add_argument("action", nargs="?", choices=("list", "cancel"), default="list", help="action (default: list)")
    runs.add_argument("runs", nargs="*", metavar="RUN", help="id of a run to cancel, as listed")
    runs.add_argument("--participant", metavar="NAME", help="list only the runs shown under this name")
    runs.add_argument("--split", metavar="S", help="list only the runs on this split")
    runs.add_argument("--state", choices=STATES, help="list only the runs in this state")
    runs.add_argument("--agent", metavar="A", help="list only the runs of this agent")
    runs.add_argument(
        "--limit", type=_positive, metavar="N", default=LIMIT, help="list at most N runs (default: %(default)s)"
    )
    runs.add_argument("--json", action="store_true", help="print JSON instead of a table")
    runs.set_defaults(command=_runs)


def _runs(arguments: argparse.Namespace) -> None:
    names = ("participant", "split", "state", "agent")
    filters = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    if arguments.action == "cancel":
        if not arguments.runs or filters:
            raise BadInput("expected ids of runs and no filters: arramon-server runs cancel RUN ...")
        _cancel(arguments)
        return
    if arguments.runs:
        raise BadInput(
            f"unexpected argument {arguments.runs[0]!r}: a list takes only filters, such as --participant NAME"
        )
    if "state" in filters:
        filters["state"] = filters["state"].upper()
    with open_journal(arguments.settings, read_only=True) as database:
        found = find_runs(database, RunFilter(**filters), arguments.limit + 1)
    listed = found[: arguments.limit]
    print(json.dumps([*map(_as_json, listed)], ensure_ascii=False, indent=1) if arguments.json else _as_text(listed))
    if len(found) > arguments.limit:
        print(f"there are more than these {arguments.limit} runs: see --limit", file=sys.stderr)


def _cancel(arguments: argparse.Namespace) -> None:
    from arramon_server.runs.cancellation import (
        Canceller,  # imported only here: the simulator takes half a second to load
    )

    with open_journal(arguments.settings) as database:
        canceller = Canceller(database, arguments.data)
        for run_id in arguments.runs:
            run = canceller.cancel(run_id)
            print(f"{run.state.lower()}: {run.run_id}, {run.agent} by {run.participant} on {run.split}", flush=True)


def _as_text(runs: Sequence[RunSummary]) -> str:
    header = ("run", "state", "participant", "agent", "split", "language", "episodes", "created", "ended")
    rows = [header, *map(_row, runs)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    cells = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]
    return "\n".join("  ".join(row).rstrip() for row in cells)


def _row(listed: RunSummary) -> tuple[str, ...]:
    run = listed.run
    times = [f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-" for time in (run.created_at, run.ended_at)]
    played = f"{listed.ended} of {listed.episodes}"
    return (run.run_id, run.state.lower(), run.participant, run.agent, run.split, run.language, played, *times)


def _as_json(listed: RunSummary) -> dict[str, Any]:
    run = listed.run
    return {
        "run_id": run.run_id,
        "participant": run.participant,
        "agent": run.agent,
        "split": run.split,
        "language": run.language,
        "sensors": run.sensors,
        "state": run.state.lower(),
        "episodes": listed.episodes,
        "episodes_ended": listed.ended,
        "created_at": run.created_at.isoformat(timespec="seconds"),
        "ended_at": run.ended_at.isoformat(timespec="seconds") if run.ended_at else None,
    }


def _positive(text: str) -> int:
    if text.isascii() and text.isdecimal() and 0 < int(text) < 1_000_000_000:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
