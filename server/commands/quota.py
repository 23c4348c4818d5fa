"""The command `quota`: sets and lists participants' limits on a split."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.episodes.split_files import read_header
from arramon_server.episodes.splits import EPISODES_FILE, split_folders
from arramon_server.errors import BadInput
from arramon_server.runs.accounts.quotas import LIMITS, DefaultQuotas, Quota, Quotas

DEFAULT = "default"
"""Argument that resets a limit to the server's settings."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    quota = commands.add_parser(
        "quota",
        parents=[common],
        help="set a participant's limits on a split, which override the settings, or list all such limits",
        usage="arramon-server quota [options] (list | PARTICIPANT SPLIT)",
    )
    quota.add_argument(
        "participant", metavar="PARTICIPANT", help="name of the participant; anonymous: all clients without a token"
    )
    quota.add_argument(
        "split", metavar="SPLIT", nargs="?", help="name of the split; without a limit, print the limits in force"
    )
    for name in LIMITS:
        quota.add_argument(
            "--" + name.replace("_", "-"), type=_limit, metavar="N", help=f"limit; 0 for none, {DEFAULT!r} to reset it"
        )
    quota.set_defaults(command=_quota)


def _quota(arguments: argparse.Namespace) -> None:
    requested = {name: getattr(arguments, name) for name in LIMITS if getattr(arguments, name) is not None}
    limits = {name: None if limit == DEFAULT else limit for name, limit in requested.items()}
    participant, split = arguments.participant, arguments.split
    if split is None and (participant != "list" or limits):
        raise BadInput("the split is missing: arramon-server quota PARTICIPANT SPLIT, or arramon-server quota list")
    with open_journal(arguments.settings) as database:
        quotas = Quotas(database, DefaultQuotas(arguments.settings, _hidden_splits(arguments.settings)))
        if split is None:
            _print(list(quotas.overrides()))
            return
        _check_split(arguments.settings, split)
        if limits:
            quotas.set(participant, split, limits)
        _print([(participant, split, quotas.of(participant, split))])


def _hidden_splits(config: Config) -> list[str]:
    folders = split_folders(config.data)
    return [folder.name for folder in folders if read_header(folder / EPISODES_FILE).hidden]


def _check_split(config: Config, split: str) -> None:
    names = [folder.name for folder in split_folders(config.data)]
    if split not in names:
        raise BadInput(f"there is no split {split!r} in {config.data}; there are {', '.join(names) or 'none'}")


def _print(rows: Sequence[tuple[str, str, Quota]]) -> None:
    print("\t".join(("participant", "split", *LIMITS)))
    for participant, split, quota in rows:
        print("\t".join((participant, split, *(str(limit or "any") for limit in asdict(quota).values()))))


def _limit(text: str) -> int | str:
    if text == DEFAULT or text.isdecimal():
        return text if text == DEFAULT else int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither a whole number nor {DEFAULT!r}")
