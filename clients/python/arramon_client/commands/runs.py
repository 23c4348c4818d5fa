"""The commands `arramon-client runs` and `cancel`: list the caller's runs, and cancel them."""

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import dry_run
from arramon_client.arguments import positive
from arramon_client.commands.base import run
from arramon_client.commands.server_options import add_server, server_of
from arramon_client.output import print_json
from arramon_client.runs.info import STATES, state_of
from arramon_client.runs.listing import listed_runs
from arramon_client.transport.connection import call

HEADER = ("run", "state", "agent", "split", "language", "episodes", "created", "ended", "")


def show(argv: Sequence[str]) -> int:
    """Run `arramon-client runs` and return its exit status."""
    parser = _parser("runs", "List your runs, latest first.")
    parser.add_argument("--split", metavar="S", help="list only runs on this split")
    parser.add_argument("--lang", metavar="L", help="list only runs in this language")
    parser.add_argument("--state", choices=STATES, help="list only runs in this state")
    parser.add_argument("--agent", metavar="A", help="list only runs of the agent with this name")
    parser.add_argument("--limit", type=positive, metavar="N", default=50, help="list at most N (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    return run(parser, argv, _show)


def cancel(argv: Sequence[str]) -> int:
    """Run `arramon-client cancel` and return its exit status."""
    parser = _parser("cancel", "Cancel your runs: every episode that is not finished is given up.")
    parser.add_argument("runs", nargs="+", metavar="RUN", help="a run's id, as shown by `arramon-client runs`")
    parser.add_argument("--json", action="store_true", help="print the cancelled runs as JSON")
    return run(parser, argv, _cancel)


def _parser(word: str, description: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=f"arramon-client {word}", allow_abbrev=False, description=description)
    add_server(parser)
    return parser


def _show(options: argparse.Namespace) -> None:
    listed: list[pb.Run] = []
    more = False
    with server_of(options) as server:
        for each in listed_runs(server):
            if _is_wanted(each, options):
                more = len(listed) == options.limit
                if more:
                    break
                listed.append(each)
    if options.json:
        print_json([*map(_as_json, listed)])
    else:
        sys.stdout.write((_table([HEADER, *map(_row, listed)]) if listed else "no matching runs") + "\n")
    if more:
        sys.stderr.write(f"only the latest {options.limit} runs are listed: see --limit\n")


def _cancel(options: argparse.Namespace) -> None:
    cancelled = []
    with server_of(options) as server:
        for run_id in options.runs:
            ended = call(server.stub.CancelRun, pb.CancelRunRequest(run_id=run_id), server.address)
            cancelled.append(_as_json(ended))
            if options.json:
                continue
            sys.stdout.write(f"{state_of(ended)}: {ended.run_id}, {ended.agent} on {ended.split}, {ended.language}\n")
            sys.stdout.flush()
    if options.json:
        print_json(cancelled)


def _is_wanted(each: pb.Run, options: argparse.Namespace) -> bool:
    found = {"split": each.split, "lang": each.language, "state": state_of(each), "agent": _agent(each)[0]}
    return all(getattr(options, name) in (None, value) for name, value in found.items())


def _agent(each: pb.Run) -> tuple[str, bool]:
    """Return the agent's name, and whether the run is a dry run."""
    return each.agent.removesuffix(dry_run.NAME_SUFFIX), each.agent.endswith(dry_run.NAME_SUFFIX)


def _row(each: pb.Run) -> tuple[str, ...]:
    played = f"{each.episodes_ended} of {each.episodes}"
    agent, is_dry = _agent(each)
    remark = "published" if each.published else "dry run" if is_dry else ""
    times = (each.created_at, each.ended_at or "-")
    return (each.run_id, state_of(each), agent, each.split, each.language, played, *times, remark)


def _table(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    cells = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]
    return "\n".join("  ".join(row).rstrip() for row in cells)


def _as_json(each: pb.Run) -> dict[str, Any]:
    return {
        "run_id": each.run_id,
        "participant": each.participant,
        "agent": _agent(each)[0],
        "dry_run": _agent(each)[1],
        "split": each.split,
        "language": each.language,
        "sensors": [*each.sensors],
        "state": state_of(each),
        "episodes": each.episodes,
        "episodes_ended": each.episodes_ended,
        "steps": each.steps,
        "created_at": each.created_at,
        "ended_at": each.ended_at or None,
        "published": each.published,
    }
