"""The command `arramon-client epochs`: list the epochs of hidden splits, and compare agents between two epochs."""

import argparse
from collections.abc import Iterable, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from arramon.v1 import evaluation_pb2, leaderboard_pb2_grpc
from arramon.v1 import leaderboard_pb2 as pb
from arramon_client.commands.base import run
from arramon_client.commands.leaderboard import SORTS, WIDTH
from arramon_client.commands.server_options import add_server, server_of
from arramon_client.errors import UsageError
from arramon_client.output import console, print_json
from arramon_client.transport.connection import call

FORMAT, VERSION = "arramon-epochs", 1
"""Header of the JSON file, which `arramon-server epoch verify` reads."""


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client epochs",
        allow_abbrev=False,
        description="List the epochs of a server's hidden splits, or compare the agents that played two of them.",
    )
    add_server(parser)
    parser.add_argument("--json", action="store_true", help="print the list as `arramon-server epoch verify` reads it")
    parser.add_argument(
        "--compare", nargs=2, metavar=("OLDER", "NEWER"), help="show how agents stand on two epochs of one split"
    )
    parser.add_argument("--lang", metavar="L", help="with --compare: language of the instructions: en, hi, ...")
    parser.add_argument(
        "--sort", choices=tuple(SORTS), default="PTC", help="with --compare: the metric (default: %(default)s)"
    )
    return run(parser, argv, _show)


def _show(options: argparse.Namespace) -> None:
    if options.compare and options.json:
        raise UsageError("--compare prints a table, and cannot be used together with --json")
    if bool(options.compare) != (options.lang is not None):
        raise UsageError("--compare needs the language of the instructions, --lang, which is used with it alone")
    shown = console(WIDTH)
    with server_of(options) as server:
        stub = leaderboard_pb2_grpc.LeaderboardStub(server.channel)
        if options.compare:
            older, newer = options.compare
            request = pb.CompareEpochsRequest(older=older, newer=newer, language=options.lang, sort=SORTS[options.sort])
            shown.print(comparison(call(stub.CompareEpochs, request, server.address), older, newer, options.sort))
            return
        epochs = call(stub.ListEpochs, pb.ListEpochsRequest(), server.address).epochs
    if options.json:
        print_json(as_file(epochs))
        return
    if not epochs:
        shown.print("the server has no epochs of hidden splits")
        return
    shown.print(table(epochs))


def as_file(epochs: Iterable[pb.Epoch]) -> dict[str, object]:
    """Return the content of the epochs' JSON file, the same as on the leaderboard's pages."""
    return {"format": FORMAT, "version": VERSION, "epochs": [_as_data(epoch) for epoch in epochs]}


def table(epochs: Iterable[pb.Epoch]) -> Table:
    """Return the table of all epochs."""
    made = _table("", "commitment: SHA-256 of what the host states of the epoch, see --json")
    for heading in ("epoch", "state", "opened", "closed", "revealed"):
        made.add_column(heading, no_wrap=True)
    made.add_column("commitment and secret", overflow="fold")
    for epoch in epochs:
        times = (time[:10] or "-" for time in (epoch.opened_at, epoch.closed_at, epoch.revealed_at))
        secret = f"\nsecret {epoch.secret}" if epoch.secret else ""
        made.add_row(Text(epoch.split), _state(epoch), *times, f"{epoch.commitment.hex()}{secret}")
    return made


def comparison(found: pb.CompareEpochsResponse, older: str, newer: str, metric: str) -> Table:
    """Return the table of agents on two epochs."""
    made = _table(
        f"{metric} on {newer} against {older}",
        "difference: the newer minus the older mean, with its 95% interval for other episodes in both; against the "
        "others: the same, minus the mean of all other agents' differences",
    )
    made.add_column("agent", overflow="fold", min_width=24)
    for heading in (older, newer, "difference", "against the others"):
        made.add_column(f"  {heading}", justify="right", no_wrap=True)
    made.add_column("code", min_width=9)
    for line in found.agents:
        apart = _interval(line.against_others) if line.HasField("against_others") else "-"
        made.add_row(
            Text(f"{line.newer.agent}\n{line.newer.participant}"),
            f"{line.older_mean:.3f}",
            f"{line.newer_mean:.3f}",
            _interval(line.difference),
            apart,
            "the same" if line.same_code else "not named in both",
        )
    if found.HasField("mean"):
        made.add_section()
        made.add_row("mean of these agents", "", "", _interval(found.mean), "", "")
    return made


def _table(title: str, caption: str) -> Table:
    return Table(title=title, caption=caption, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False)


def _interval(score: evaluation_pb2.Score) -> str:
    return f"{score.mean:+.3f}\n{score.low:+.3f} to {score.high:+.3f}"


def _state(epoch: pb.Epoch) -> str:
    return pb.EpochState.Name(epoch.state).removeprefix("EPOCH_STATE_").lower()


def _as_data(epoch: pb.Epoch) -> dict[str, object]:
    return {
        "split": epoch.split,
        "state": _state(epoch),
        "statement": epoch.statement.decode(),
        "commitment": epoch.commitment.hex(),
        "opened_at": epoch.opened_at or None,
        "closed_at": epoch.closed_at or None,
        "revealed_at": epoch.revealed_at or None,
        "secret": epoch.secret or None,
        "command": epoch.command or None,
    }
