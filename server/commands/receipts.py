"""`key` and `rescore`: what receipts are signed with, and whether what was written down is what was played."""

import argparse
import sys
from contextlib import closing

from server.commands import Commands
from server.config import Config
from server.configuring import add_flag
from server.episodes.splits import read_splits
from server.errors import BadInput, Conflict
from server.runs.database import Database
from server.runs.journal import Journal
from server.runs.records import RUNNING
from server.runs.rescoring import Rescored, Rescorer
from server.runs.signing import KnownKeys, SigningKey


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds both."""
    key = commands.add_parser(
        "key", parents=[common], help="print the public key that receipts are signed with, for everyone to check them"
    )
    add_flag(key, "signing_key")
    what = key.add_mutually_exclusive_group()
    what.add_argument("--pem", action="store_true", help="print it as openssl reads it, in place of hexadecimal")
    what.add_argument("--all", action="store_true", help="print every key that the journal knows, the present one last")
    what.add_argument(
        "--adopt", action="store_true", help="sign with this host's key from now on, whatever it was before"
    )
    key.set_defaults(command=_key)

    rescore = commands.add_parser(
        "rescore", parents=[common], help="play runs again from the journal, and compare; status 1 if anything differs"
    )
    rescore.add_argument("runs", nargs="*", metavar="RUN", help="its id")
    rescore.add_argument("--all", action="store_true", help="all runs that are over")
    rescore.set_defaults(command=_rescore)


def _key(arguments: argparse.Namespace) -> None:
    config: Config = arguments.settings
    if arguments.all:
        with closing(Database(config.journal_url, read_only=True)) as database:
            for known in KnownKeys(database).all():
                print(f"{known.key.hex()}  since {known.since:%Y-%m-%dT%H:%MZ}")
        return
    path = config.signing_key_path
    if not path.exists():
        print(f"there was no key at {path}: a new one is made there", file=sys.stderr)
    key = SigningKey(path)
    if arguments.adopt:
        with closing(Database(config.journal_url)) as database:
            changed = KnownKeys(database).adopt(key.public)
        print(
            "adopted; servers that run are to be started again" if changed else "it is the key already", file=sys.stderr
        )
    print(key.public_pem().strip() if arguments.pem else key.public.hex())


def _rescore(arguments: argparse.Namespace) -> int:
    config: Config = arguments.settings
    if bool(arguments.runs) == arguments.all:
        raise BadInput("which runs? name some, or say --all")
    different = 0
    with (
        closing(Database(config.journal_url, read_only=True)) as database,
        closing(Rescorer(database, read_splits(config.data))) as rescorer,
    ):
        for run_id in arguments.runs or _over(Journal(database)):
            try:
                rescored = rescorer.rescore(run_id)
            except Conflict as error:
                print(error, flush=True)
                different += 1
            else:
                print(*_lines(rescored), sep="\n", flush=True)
                different += bool(rescored.differences)
    return int(different > 0)


def _over(journal: Journal) -> list[str]:
    """The runs that are over, the earliest first."""
    found, last = [], None
    while page := journal.runs(1000, last):
        found += [run.run_id for run in page if run.state != RUNNING]
        last = page[-1]
    return found[::-1]


def _lines(rescored: Rescored) -> list[str]:
    played = f"run {rescored.run_id}: {rescored.episodes} episodes, {rescored.steps} steps"
    if not rescored.differences:
        return [f"{played}: identical" + ("" if rescored.has_receipt else "; it has no receipt yet")]
    return [f"{played}: DIFFERENT", *(f"  {each}" for each in rescored.differences)]
