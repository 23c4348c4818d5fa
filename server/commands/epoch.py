"""The command `epoch`: epochs of hidden splits, opened, closed, revealed, listed and verified."""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from arramon_server import __version__
from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.commands.wording import describe
from arramon_server.configuration.config import Config
from arramon_server.episodes.epochs import (
    LIST_FORMAT,
    LIST_VERSION,
    Statement,
    check_secret,
    commitment_of,
    digest_of,
    epoch_of,
    read_statement,
)
from arramon_server.episodes.files import read_object
from arramon_server.episodes.splits import Split, folder_of
from arramon_server.errors import BadFile, BadInput, Conflict
from arramon_server.runs.storage.epochs import Epochs


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    epoch = commands.add_parser("epoch", help="open, close, reveal, list or verify epochs of a hidden split")
    actions = epoch.add_subparsers(title="actions", required=True, metavar="ACTION")

    open_ = actions.add_parser(
        "open",
        parents=[common],
        help="generate the next epoch of a hidden split from a new secret, and publish the commitment",
    )
    open_.add_argument("base", metavar="SPLIT", help="hidden split of the data set, such as test_unseen")
    open_.add_argument("--scale", type=float, default=1.0, help="share of its episodes (default: %(default)s)")
    open_.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    open_.add_argument("--no-trial", action="store_true", help="keep episodes that no agent has tried: quicker")
    open_.set_defaults(command=_open)

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

    verify = actions.add_parser(
        "verify",
        parents=[common],
        help="check a host's list of epochs, and that the secret gives the data; exit status 1 if not",
    )
    verify.add_argument("file", type=Path, metavar="FILE", help="list of epochs, from the host's pages or its server")
    verify.add_argument("split", metavar="EPOCH", help="the epoch's split, which is generated in the data folder")
    verify.add_argument(
        "--commitment", metavar="HEX", help="commitment that was noted when the epoch opened, or is in a receipt"
    )
    verify.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    verify.set_defaults(command=_verify)


def _open(arguments: argparse.Namespace) -> None:
    from arramon_dataset.generation.checkpoint import digest_of_sources
    from arramon_dataset.generation.sizes import epoch_plan
    from arramon_server.episodes.secret import epoch_secret

    config: Config = arguments.settings
    epoch_plan(arguments.base, 1).count(arguments.scale)  # Both are checked before anything is made.
    with open_journal(config, new=True) as database:
        known = [found for record in Epochs(database).all() if (found := epoch_of(record.split))]
    number = 1 + max((number for base, number in known if base == arguments.base), default=0)
    plan = epoch_plan(arguments.base, number)
    secret = epoch_secret(config.data, plan.name)
    split = _generate(
        config.data, plan.name, secret, scale=arguments.scale, jobs=arguments.jobs, tried=not arguments.no_trial
    )
    statement = Statement(
        split=plan.name,
        base=arguments.base,
        sections=plan.sections,
        scale=arguments.scale,
        episodes=len(split.episodes),
        tried=not arguments.no_trial,
        generator=__version__,
        sources=digest_of_sources(),
        data_hash=split.data_hash,
        secret_sha256=digest_of(secret),
    )
    with open_journal(config) as database:
        record = Epochs(database).open(plan.name, statement.written())
    print(describe(split))
    print(f"open: {plan.name}, commitment {record.commitment.hex()}")
    print("restart the servers to serve it", file=sys.stderr)


def _close(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings) as database:
        running = Epochs(database).close(arguments.split)
    print(f"closed: {arguments.split}; no new runs begin on it")
    if running:
        print(f"{len(running)} runs are still being played, and may be played to their end:", file=sys.stderr)
        print(*running, sep="\n", file=sys.stderr)


def _reveal(arguments: argparse.Namespace) -> None:
    from arramon_server.episodes.secret import epoch_secret, secret_path

    config: Config = arguments.settings
    with open_journal(config) as database:
        epochs = Epochs(database)
        record = epochs.of(arguments.split)
        path = secret_path(config.data, arguments.split)
        if not path.exists():
            raise BadFile(path, "is missing: expected the epoch's secret; restore it from a backup")
        secret = epoch_secret(config.data, arguments.split)
        statement = read_statement(record.statement, f"statement of {record.split}")
        if digest_of(secret) != statement.secret_sha256:
            raise BadFile(path, "is not the secret that the host committed to when it opened the epoch")
        if arguments.forfeit and record.closed_at is not None:
            _forfeit(config, epochs, arguments.split)
        epochs.reveal(arguments.split, secret)
    print(f"revealed: {arguments.split}, secret {secret}")
    print(f"anyone can generate it: {statement.command} {secret}")


def _forfeit(config: Config, epochs: Epochs, split: str) -> None:
    from arramon_server.runs.cancellation import (
        Canceller,  # imported only here: the simulator takes half a second to load
    )

    with open_journal(config) as database:
        canceller = Canceller(database, config.data)
        for run_id in epochs.running(split):
            try:
                run = canceller.cancel(run_id)
            except Conflict:  # It has ended meanwhile.
                continue
            print(f"{run.state.lower()}: {run.run_id}, {run.agent} by {run.participant}", file=sys.stderr)


def _list(arguments: argparse.Namespace) -> None:
    from arramon_server.board.epochs import as_file, epoch_with_statement

    with open_journal(arguments.settings, read_only=True) as database:
        epochs = [epoch_with_statement(record) for record in Epochs(database).all()]
    if arguments.json:
        print(json.dumps(as_file(epochs), indent=2, ensure_ascii=False))
        return
    rows: list[tuple[str, ...]] = [("epoch", "state", "episodes", "opened", "closed", "revealed", "commitment")]
    for epoch in epochs:
        record = epoch.record
        times = (record.opened_at, record.closed_at, record.revealed_at)
        told = [f"{time:%Y-%m-%dT%H:%MZ}" if time is not None else "-" for time in times]
        rows.append((record.split, record.state, str(epoch.statement.episodes), *told, record.commitment.hex()))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _verify(arguments: argparse.Namespace) -> int:
    told = _find(arguments.file, arguments.split)
    statement = read_statement(_text(arguments.file, told, "statement").encode(), arguments.file)
    if statement.split != arguments.split:
        raise BadFile(arguments.file, f"has the statement of {statement.split!r} for {arguments.split!r}")
    if told.get("secret") is None:
        raise BadInput(f"the secret of {arguments.split!r} is not revealed yet; until then only its hash is public")
    secret = check_secret(_text(arguments.file, told, "secret"))
    commitment = commitment_of(statement.written()).hex()
    wrong = []
    for name, noted in (("the list", told.get("commitment")), ("--commitment", arguments.commitment)):
        if noted is not None and str(noted).lower() != commitment:
            wrong.append(f"the statement's commitment is {commitment}, but {name} has {noted}")
    if digest_of(secret) != statement.secret_sha256:
        wrong.append(f"the secret's SHA-256 is {digest_of(secret)}, but the statement has {statement.secret_sha256}")
    if wrong:
        print(f"{arguments.split}: DIFFERENT", *(f"  {line}" for line in wrong), sep="\n")
        return 1
    print(f"commitment {commitment}: statement and secret belong to it", flush=True)
    if folder_of(arguments.data, arguments.split).exists():
        raise BadInput(f"{arguments.data} has the split {arguments.split!r} already; expected a folder without it")
    split = _generate(
        arguments.data, statement.split, secret, scale=statement.scale, jobs=arguments.jobs, tried=statement.tried
    )
    found = [
        f"{name} is {made}, but the statement has {said}"
        for name, made, said in (
            ("the number of episodes", len(split.episodes), statement.episodes),
            ("the list of sections", tuple(split.sections), statement.sections),
            ("the hash of the data", split.data_hash, statement.data_hash),
        )
        if made != said
    ]
    if not found:
        print(f"{describe(split)}: identical")
        return 0
    print(f"{arguments.split}: DIFFERENT", *(f"  {line}" for line in found), sep="\n")
    _explain(statement)
    return 1


def _explain(statement: Statement) -> None:
    """Say so if another version of the generator can be the reason for other data."""
    from arramon_dataset.generation.checkpoint import digest_of_sources

    if digest_of_sources() != statement.sources:
        print(
            f"the generator differs: the host used version {statement.generator} with the sources "
            f"{statement.sources[:12]}, this is version {__version__} with {digest_of_sources()[:12]}",
            file=sys.stderr,
        )


def _generate(data: Path, name: str, secret: str, *, scale: float, jobs: int, tried: bool) -> Split:
    from arramon_dataset.instruction_writer import generate_splits

    def tell(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    (split,) = generate_splits(data, [name], scale=scale, seed=0, jobs=jobs, tell=tell, trial=tried, secret=secret)
    return split


def _find(path: Path, split: str) -> dict[str, Any]:
    """Return what a host's list says of an epoch."""
    content = read_object(path)
    if (content.get("format"), content.get("version")) != (LIST_FORMAT, LIST_VERSION):
        raise BadFile(path, f"is not a list of epochs: expected the format {LIST_FORMAT!r}, version {LIST_VERSION}")
    epochs = content.get("epochs")
    found = [one for one in epochs if isinstance(one, dict)] if isinstance(epochs, list) else []
    for one in found:
        if one.get("split") == split:
            return one
    raise BadInput(
        f"there is no epoch {split!r} in {path}; there are {', '.join(str(one.get('split')) for one in found)}"
    )


def _text(path: Path, told: dict[str, Any], name: str) -> str:
    value = told.get(name)
    if not isinstance(value, str):
        raise BadFile(path, f"is {value!r}, expected a text", field=name)
    return value
