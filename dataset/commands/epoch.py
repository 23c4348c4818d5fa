"""The actions `open` and `verify` of the command `epoch`, which generate an epoch of a hidden split."""

import argparse
import sys
from pathlib import Path
from typing import Any

from arramon_server import __version__
from arramon_server.commands import Commands
from arramon_server.commands.epoch import next_number, open_epoch
from arramon_server.commands.split_description import describe_split
from arramon_server.configuration.config import Config
from arramon_server.episodes.epoch_statement import (
    LIST_FORMAT,
    LIST_VERSION,
    EpochStatement,
    check_secret,
    commitment_of,
    read_statement,
    secret_digest,
)
from arramon_server.episodes.split_files import read_json_object
from arramon_server.episodes.splits import Split, split_folder
from arramon_server.errors import BadFile, BadInput


def add_actions(actions: Commands, common: argparse.ArgumentParser) -> None:
    """Add both actions."""
    open_ = actions.add_parser(
        "open",
        parents=[common],
        help="generate the next epoch of a hidden split from a new secret, and publish the commitment",
    )
    open_.add_argument("base", metavar="SPLIT", help="hidden split of the data set, such as test_unseen")
    open_.add_argument("--scale", type=float, default=1.0, help="share of its episodes (default: %(default)s)")
    open_.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    open_.add_argument("--no-trial", action="store_true", help="keep episodes without a trial by an agent: faster")
    open_.set_defaults(command=_open)

    verify = actions.add_parser(
        "verify",
        parents=[common],
        help="check a host's list of epochs, and that the secret reproduces the data; exit status 1 if not",
    )
    verify.add_argument("file", type=Path, metavar="FILE", help="list of epochs, from the host's pages or its server")
    verify.add_argument("split", metavar="EPOCH", help="the epoch's split, which will be generated in the data folder")
    verify.add_argument("--commitment", metavar="HEX", help="commitment noted when the epoch opened, or from a receipt")
    verify.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    verify.set_defaults(command=_verify)


def _open(arguments: argparse.Namespace) -> None:
    from arramon_dataset.generation.checkpoint import digest_of_sources
    from arramon_dataset.generation.split_specs import epoch_spec
    from arramon_server.episodes.split_secrets import epoch_secret

    config: Config = arguments.settings
    epoch_spec(arguments.base, 1).count(arguments.scale)  # Checks both before generation starts.
    plan = epoch_spec(arguments.base, next_number(config, arguments.base))
    secret = epoch_secret(config.data, plan.name)
    split = _generate(
        config.data, plan.name, secret, scale=arguments.scale, jobs=arguments.jobs, tried=not arguments.no_trial
    )
    statement = EpochStatement(
        split=plan.name,
        base=arguments.base,
        sections=plan.sections,
        scale=arguments.scale,
        episodes=len(split.episodes),
        tried=not arguments.no_trial,
        generator=__version__,
        sources=digest_of_sources(),
        data_hash=split.data_hash,
        secret_sha256=secret_digest(secret),
    )
    commitment = open_epoch(config, statement)
    print(describe_split(split))
    print(f"open: {plan.name}, commitment {commitment.hex()}")
    print("restart the servers to serve it", file=sys.stderr)


def _verify(arguments: argparse.Namespace) -> int:
    entry = _find(arguments.file, arguments.split)
    statement = read_statement(_text(arguments.file, entry, "statement").encode(), arguments.file)
    if statement.split != arguments.split:
        raise BadFile(arguments.file, f"has the statement of {statement.split!r} for {arguments.split!r}")
    if entry.get("secret") is None:
        raise BadInput(f"the secret of {arguments.split!r} is not revealed yet; until then only its hash is public")
    secret = check_secret(_text(arguments.file, entry, "secret"))
    commitment = commitment_of(statement.canonical_json()).hex()
    wrong = []
    for name, noted in (("the list", entry.get("commitment")), ("--commitment", arguments.commitment)):
        if noted is not None and str(noted).lower() != commitment:
            wrong.append(f"the statement's commitment is {commitment}, but {name} has {noted}")
    if secret_digest(secret) != statement.secret_sha256:
        wrong.append(
            f"the secret's SHA-256 is {secret_digest(secret)}, but the statement has {statement.secret_sha256}"
        )
    if wrong:
        print(f"{arguments.split}: DIFFERENT", *(f"  {line}" for line in wrong), sep="\n")
        return 1
    print(f"commitment {commitment}: statement and secret belong to it", flush=True)
    if split_folder(arguments.data, arguments.split).exists():
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
        print(f"{describe_split(split)}: identical")
        return 0
    print(f"{arguments.split}: DIFFERENT", *(f"  {line}" for line in found), sep="\n")
    _explain(statement)
    return 1


def _explain(statement: EpochStatement) -> None:
    """Print a warning if a different version of the generator may explain the difference."""
    from arramon_dataset.generation.checkpoint import digest_of_sources

    if digest_of_sources() != statement.sources:
        print(
            f"the generator differs: the host used version {statement.generator} with the sources "
            f"{statement.sources[:12]}, this is version {__version__} with {digest_of_sources()[:12]}",
            file=sys.stderr,
        )


def _generate(data: Path, name: str, secret: str, *, scale: float, jobs: int, tried: bool) -> Split:
    from arramon_dataset.instruction_writer import generate_splits

    def print_line(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    (split,) = generate_splits(
        data, [name], scale=scale, seed=0, jobs=jobs, write_line=print_line, trial=tried, secret=secret
    )
    return split


def _find(path: Path, split: str) -> dict[str, Any]:
    """Return the entry of an epoch in a host's list."""
    content = read_json_object(path)
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


def _text(path: Path, entry: dict[str, Any], name: str) -> str:
    value = entry.get(name)
    if not isinstance(value, str):
        raise BadFile(path, f"is {value!r}, expected a text", field=name)
    return value
