"""The command `void`: voids episodes, so that no run's scores include them, and lists a split's corrections."""

import argparse
import sys

from arramon_server.board.corrector import AlreadyCorrected, Corrector
from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import add_flag
from arramon_server.episodes.split_changes import describe_episodes
from arramon_server.episodes.splits import read_splits
from arramon_server.errors import BadInput
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage.corrections import Corrections, voided_by


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    void = commands.add_parser(
        "void",
        parents=[common],
        help="void episodes of a split, whose scores count in no run from then on, or list the corrections of a split; "
        "possible while servers are running",
    )
    void.add_argument("split", metavar="SPLIT", help="the split's name")
    void.add_argument("episodes", nargs="*", metavar="EPISODE", help="ids of the episodes; none: list the corrections")
    void.add_argument("--reason", metavar="TEXT", help="why, in one line, which the leaderboard shows")
    void.add_argument("--restore", action="store_true", help="let void episodes count again")
    add_flag(void, "signing_key")
    void.set_defaults(command=_void)


def _void(arguments: argparse.Namespace) -> None:
    if not arguments.episodes:
        if arguments.reason is not None or arguments.restore:
            raise BadInput("expected ids of episodes: arramon-server void SPLIT EPISODE... --reason TEXT")
        _list(arguments)
        return
    if arguments.reason is None:
        raise BadInput("expected a reason, which the leaderboard shows: --reason TEXT")
    config: Config = arguments.settings
    splits = read_splits(config.data)
    with open_journal(config) as database:
        corrector = Corrector(database, splits, checked_signing_key(config, KnownKeys(database)))
        try:
            made = corrector.void(arguments.split, arguments.episodes, arguments.reason, restore=arguments.restore)
        except AlreadyCorrected as error:
            if not (revised := corrector.renew_receipts(arguments.split)):
                raise
            print(f"{error}, by a command that stopped before all receipts were signed\nnew receipts: {revised}")
            return
        print(
            f"{'restored' if arguments.restore else 'void'}: {describe_episodes(made.episodes)} of split {made.split}",
            flush=True,
        )
        print(f"new receipts: {corrector.renew_receipts(made.split)}")
    if splits[made.split].hidden:
        print(
            "the split is hidden: the difference between the scores before and after is about these episodes alone, as "
            "far as the rounding of the scores tells it",
            file=sys.stderr,
        )


def _list(arguments: argparse.Namespace) -> None:
    with open_journal(arguments.settings, read_only=True) as database:
        found = Corrections(database).on(arguments.split)
    for one in found:
        data = f", data {one.data_before[:12]} to {one.data_after[:12]}" if one.data_before and one.data_after else ""
        print(f"{one.made_at:%Y-%m-%dT%H:%MZ}  {one.kind}  {describe_episodes(one.episodes)}{data}: {one.reason}")
    void = voided_by(found)
    print(f"void now: {', '.join(sorted(void)) or 'none'}")


def checked_signing_key(config: Config, known: KnownKeys) -> SigningKey:
    """Return the host's signing key, after a check that it is the journal's current one.

    Raises:
        Conflict: if the host's key is not the journal's current key.
    """
    key = SigningKey(config.signing_key_path)
    known.check(key.public)
    return key
