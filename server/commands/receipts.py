"""The commands `key` and `rescore`: the key that signs receipts, and replays that verify recorded runs."""

import argparse
import sys
from contextlib import closing
from pathlib import Path

from arramon_server.board.corrector import Corrector
from arramon_server.commands import Commands
from arramon_server.commands.journal import check_data_folder, open_journal
from arramon_server.commands.void import checked_signing_key
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import add_flag
from arramon_server.episodes.split_lookup import SEPARATOR
from arramon_server.episodes.splits import read_split, read_splits
from arramon_server.errors import BadInput, Conflict
from arramon_server.runs.results.receipt_file import rescore_file
from arramon_server.runs.results.rescoring import Rescorer, RescoringResult
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING
from arramon_server.visible_text import shown


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add both commands."""
    key = commands.add_parser(
        "key", parents=[common], help="print the public key with which anyone can check the server's receipts"
    )
    add_flag(key, "signing_key")
    what = key.add_mutually_exclusive_group()
    what.add_argument("--pem", action="store_true", help="print it in PEM format instead of hexadecimal")
    what.add_argument("--all", action="store_true", help="print all keys in the journal, the current one last")
    what.add_argument(
        "--adopt", action="store_true", help="make this host's key the current one, replacing any other in the journal"
    )
    key.set_defaults(command=_key)

    rescore = commands.add_parser(
        "rescore",
        parents=[common],
        help="replay runs from the journal and compare their scores; exit status 1 if anything differs",
    )
    rescore.add_argument("runs", nargs="*", metavar="RUN", help="id of a run")
    rescore.add_argument("--all", action="store_true", help="rescore all runs that are over")
    rescore.add_argument(
        "--receipt", type=Path, metavar="FILE", help="rescore the receipt in this file, without a journal"
    )
    rescore.add_argument(
        "--actions", type=Path, metavar="FILE", help="with --receipt: the run's actions, or a client's results file"
    )
    rescore.add_argument(
        "--adopt",
        metavar="SPLIT",
        help="score all runs of a split again, whose data was corrected, and sign new receipts; needs --before",
    )
    rescore.add_argument("--before", type=Path, metavar="FOLDER", help="with --adopt: the split's folder as it was")
    rescore.add_argument("--reason", metavar="TEXT", help="with --adopt: why, in one line, which the leaderboard shows")
    add_flag(rescore, "signing_key")
    rescore.set_defaults(command=_rescore)


def _key(arguments: argparse.Namespace) -> None:
    config: Config = arguments.settings
    if arguments.all:
        with open_journal(config, read_only=True) as database:
            for known in KnownKeys(database).all():
                print(f"{known.key.hex()}  since {known.since:%Y-%m-%dT%H:%MZ}")
        return
    path = config.signing_key_path
    if config.signing_key is None:
        check_data_folder(config)
    if not path.exists():
        print(f"no key at {path}: creating a new one", file=sys.stderr)
    key = SigningKey(path)
    if arguments.adopt:
        with open_journal(config) as database:
            changed = KnownKeys(database).adopt(key.public)
        print(
            "key adopted; restart all running servers" if changed else "this is the current key already",
            file=sys.stderr,
        )
    print(key.public_pem().strip() if arguments.pem else key.public.hex())


def _rescore(arguments: argparse.Namespace) -> int:
    config: Config = arguments.settings
    adopts = arguments.adopt is not None
    if bool(arguments.runs) + arguments.all + (arguments.receipt is not None) + adopts != 1:
        raise BadInput("expected either ids of runs, or --all, or --receipt FILE, or --adopt SPLIT")
    if any((one is None) is adopts for one in (arguments.before, arguments.reason)):
        raise BadInput("--adopt SPLIT, --before FOLDER and --reason TEXT are used together")
    if adopts:
        return _adopt(arguments)
    if (arguments.receipt is None) != (arguments.actions is None):
        raise BadInput("--receipt FILE and --actions FILE are used together: a receipt holds no actions")
    if arguments.receipt is not None:
        rescored = rescore_file(arguments.receipt, arguments.actions, read_splits(config.data))
        print(*_lines(rescored), sep="\n")
        print(f"signed with the key {rescored.public_key}; compare it with the host's (`arramon-client verify`)")
        return int(bool(rescored.differences))
    different = 0
    with (
        open_journal(config, read_only=True) as database,
        closing(Rescorer(database, read_splits(config.data))) as rescorer,
    ):
        for run_id in arguments.runs or _ended_runs(Journal(database)):
            try:
                rescored = rescorer.rescore(run_id)
            except Conflict as error:
                print(error, flush=True)
                different += 1
            else:
                print(*_lines(rescored), sep="\n", flush=True)
                different += bool(rescored.differences)
    return int(different > 0)


def _adopt(arguments: argparse.Namespace) -> int:
    config: Config = arguments.settings
    before = read_split(arguments.before)
    if before.name != arguments.adopt:
        raise BadInput(f"{arguments.before} is the split {before.name!r}, expected {arguments.adopt!r} as it was")
    done = failed = receipts = 0
    with open_journal(config) as database:
        corrector = Corrector(database, read_splits(config.data), checked_signing_key(config, KnownKeys(database)))
        for found in corrector.rescore(before, arguments.reason):
            if found.problem:
                print(f"run {found.run.run_id}: NOT scored again: {found.problem}", flush=True)
            else:
                print(f"run {found.run.run_id}: scores changed in {found.changed} episodes", flush=True)
            failed, done = failed + bool(found.problem), done + (not found.problem)
            receipts += found.has_new_receipt
        receipts += corrector.renew_receipts(before.name)  # receipts that an interrupted call did not sign
    print(f"scored again: {done} runs; new receipts: {receipts}")
    if failed:
        print(f"{failed} runs stay on the data before, without a rank", file=sys.stderr)
    print("restart the servers to serve the corrected data", file=sys.stderr)
    return int(failed > 0)


def _ended_runs(journal: Journal) -> list[str]:
    """Return the ids of all ended runs on splits of the data folder, the earliest first.

    Others, such as verifications of collected texts, have their data elsewhere; they are never published.
    """
    found, last = [], None
    while page := journal.runs(1000, last):
        found += [run.run_id for run in page if run.state != RUNNING and SEPARATOR not in run.split]
        last = page[-1]
    return found[::-1]


def _lines(rescored: RescoringResult) -> list[str]:
    played = f"run {rescored.run_id}: {rescored.episodes} episodes, {rescored.steps} steps"
    if not rescored.differences:
        return [f"{played}: identical" + ("" if rescored.has_receipt else "; it has no receipt yet")]
    return [f"{played}: DIFFERENT", *(f"  {shown(each)}" for each in rescored.differences)]
