"""The command `epoch`: closes, reveals and lists the epochs of hidden splits.

Opening and verifying an epoch generate it, so the data set's package adds these actions: it has an entry point `epoch`
in the group `arramon.commands`, which names a module with a function `add_actions`.
"""

import argparse
import json
import sys
from importlib import import_module
from importlib.metadata import entry_points

from arramon_server.commands import ENTRY_POINTS, Commands
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.episodes.epoch_statement import EpochStatement, parse_epoch_name, read_statement, secret_digest
from arramon_server.errors import BadFile, Conflict
from arramon_server.runs.storage.epoch_store import EpochStore


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    epoch = commands.add_parser("epoch", help="open, close, reveal, list or verify epochs of a hidden split")
    actions = epoch.add_subparsers(title="actions", required=True, metavar="ACTION")
    for entry in entry_points(group=ENTRY_POINTS, name="epoch"):
        import_module(entry.module).add_actions(actions, common)

    close = actions.add_parser("close", parents=[common], help="accept no new runs; possible while servers are running")
    close.add_argument("split", metavar="EPOCH", help="the epoch's split, such as test_unseen_e1")
    close.set_defaults(command=_close)

    reveal = actions.add_parser("reveal", parents=[common], help="publish the secret of a closed epoch")
    reveal.add_argument("split", metavar="EPOCH", help="the epoch's split, such as test_unseen_e1")
    reveal.add_argument("--forfeit", action="store_true", help="end runs that are still being played: they forfeit")
    reveal.set_defaults(command=_reveal)

    list_ = actions.add_parser("list", parents=[common], help="list all epochs, the latest first")
    list_.add_argument("--json", action="store_true", help="print them as the file that `epoch verify` reads")
    list_.set_defaults(command=_list)


def next_number(config: Config, base: str) -> int:
    """Return the number of a hidden split's next epoch; 1 if the host has opened none."""
    with open_journal(config, new=True) as database:
        known = [found for record in EpochStore(database).all() if (found := parse_epoch_name(record.split))]
    return 1 + max((number for split, number in known if split == base), default=0)


def open_epoch(config: Config, statement: EpochStatement) -> bytes:
    """Record that an epoch is open, and return its published commitment."""
    with open_journal(config) as database:
        return EpochStore(database).open(statement.split, statement.canonical_json()).commitment


def _close(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings) as database:
        running = EpochStore(database).close(arguments.split)
    print(f"closed: {arguments.split}; no new runs begin on it")
    if running:
        print(f"{len(running)} runs are still being played, and may be played to their end:", file=sys.stderr)
        print(*running, sep="\n", file=sys.stderr)


def _reveal(arguments: argparse.Namespace) -> None:
    from arramon_server.episodes.split_secrets import epoch_secret, secret_path

    config: Config = arguments.settings
    with open_journal(config) as database:
        epochs = EpochStore(database)
        record = epochs.of(arguments.split)
        path = secret_path(config.data, arguments.split)
        if not path.exists():
            raise BadFile(path, "is missing: expected the epoch's secret; restore it from a backup")
        secret = epoch_secret(config.data, arguments.split)
        statement = read_statement(record.statement, f"statement of {record.split}")
        if secret_digest(secret) != statement.secret_sha256:
            raise BadFile(path, "is not the secret that the host committed to when it opened the epoch")
        if arguments.forfeit and record.closed_at is not None:
            _forfeit(config, epochs, arguments.split)
        epochs.reveal(arguments.split, secret)
    print(f"revealed: {arguments.split}, secret {secret}")
    print(f"anyone can generate it: {statement.command} {secret}")


def _forfeit(config: Config, epochs: EpochStore, split: str) -> None:
    # Imported only here: the simulator takes half a second to load.
    from arramon_server.runs.cancellation import Canceller

    with open_journal(config) as database:
        canceller = Canceller(database, config.data)
        for run_id in epochs.running(split):
            try:
                run = canceller.cancel(run_id)
            except Conflict:  # It has ended meanwhile.
                continue
            print(f"{run.state.lower()}: {run.run_id}, {run.agent} by {run.participant}", file=sys.stderr)


def _list(arguments: argparse.Namespace) -> None:
    from arramon_server.board.epoch_board import epoch_list_file, epoch_with_statement

    with open_journal(arguments.settings, read_only=True) as database:
        epochs = [epoch_with_statement(record) for record in EpochStore(database).all()]
    if arguments.json:
        print(json.dumps(epoch_list_file(epochs), indent=2, ensure_ascii=False))
        return
    rows: list[tuple[str, ...]] = [("epoch", "state", "episodes", "opened", "closed", "revealed", "commitment")]
    for epoch in epochs:
        record = epoch.record
        times = (record.opened_at, record.closed_at, record.revealed_at)
        cells = [f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-" for time in times]
        rows.append((record.split, record.state, str(epoch.statement.episodes), *cells, record.commitment.hex()))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
