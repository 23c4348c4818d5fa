"""The command `arramon-client verify`: check a receipt's signature, the host's key and the actions that were sent."""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import grpc
from rich.console import Console

from arramon.v1 import evaluation_pb2, leaderboard_pb2, leaderboard_pb2_grpc
from arramon_client import receipts
from arramon_client.commands.base import ERROR, SUCCESS, run
from arramon_client.errors import NotArramonError, ReceiptError, RefusedError, UsageError
from arramon_client.notices import signed_corrections, superseded_line
from arramon_client.output import console, print_json
from arramon_client.printable import many_lines, one_line
from arramon_client.receipts import Receipt
from arramon_client.results import TABLE_WIDTH, score_table
from arramon_client.transport.access import access_of, add_access
from arramon_client.transport.connection import call, connect

KEY_NOT_CHECKED = 3
"""Exit status: the receipt is intact, but its key was not compared with the host's."""

SUPERSEDED = 4
"""Exit status: the receipt is valid, but the host has since signed another one."""


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 valid, 1 not valid, 2 usage, 3 the key was not checked."""
    parser = argparse.ArgumentParser(
        prog="arramon-client verify",
        allow_abbrev=False,
        description="Check receipts: their signatures, the host's key and the actions that this client sent.",
        epilog="exit status: 0 all receipts are valid; 1 one of them is not, for the reasons printed; 2 wrong usage; "
        "3 the receipts are intact, but no host's key was given to compare their keys with; 4 all are valid, but the "
        "host has corrected a split since and signed another receipt (checked with --server, for published runs)",
    )
    parser.add_argument("receipts", type=Path, nargs="+", metavar="RECEIPT", help="a file RUN.receipt.json; repeatable")
    key = parser.add_mutually_exclusive_group()
    key.add_argument(
        "--key",
        metavar="FILE|HEX",
        help="the host's public key in hexadecimal, or a file with it in hexadecimal or PEM",
    )
    key.add_argument("--server", metavar="ADDR", help="get the key from the host's server: host:port or unix:/path")
    parser.add_argument(
        "--results", type=Path, metavar="FILE", help="results file of the run (default: RUN.json beside the receipt)"
    )
    parser.add_argument("--json", action="store_true", help="print what was checked as JSON")
    add_access(parser)
    return run(parser, argv, _verify)


@dataclass(frozen=True)
class _ReceiptCheck:
    """Result of checking one receipt, which is valid unless there is an error.

    Attributes:
        path: path of its file.
        error: why it is not valid; empty if it is.
        receipt: its content; None if it cannot be read.
        results: result of the comparison with the results file; empty if there was none.
        superseded: message that the host has since signed another receipt; empty if it has not, or no server was given.
    """

    path: Path
    error: str = ""
    receipt: Receipt | None = None
    results: str = ""
    superseded: str = ""

    def as_json(self, key_checked: bool) -> dict[str, Any]:
        return {
            "file": str(self.path),
            "valid": not self.error,
            "error": self.error or None,
            "key": self.receipt.public_key.hex() if self.receipt is not None else None,
            "key_checked": key_checked,
            "results": self.results or None,
            "superseded": self.superseded or None,
            "receipt": self.receipt.content if self.receipt is not None else None,
        }


def _verify(options: argparse.Namespace) -> int:
    if options.results is not None and len(options.receipts) > 1:
        raise UsageError("--results is the file of one run, and cannot be used together with several receipts")
    key, whose = _host_key(options)
    checked = []
    for path in options.receipts:
        one = _check(path, options.results, key, whose)
        if one.receipt is not None and key is not None:
            one = replace(one, superseded=_superseded(options, one.receipt))
        checked.append(one)
        if not options.json:
            _show_one(one, key, whose, named=len(options.receipts) > 1)
    if options.json:
        found = [one.as_json(key is not None) for one in checked]
        print_json(found if len(found) > 1 else found[0])
        for one in checked:
            if one.error:
                sys.stderr.write(f"error: {many_lines(one.error)}\n")
    if any(one.error for one in checked):
        return ERROR
    if any(one.superseded for one in checked):
        return SUPERSEDED
    return SUCCESS if key is not None else KEY_NOT_CHECKED


def _check(path: Path, results_path: Path | None, key: bytes | None, whose: str) -> _ReceiptCheck:
    try:
        receipt = receipts.read_receipt(path)
        if key is not None:
            receipts.check_key(receipt, key, whose)
        results = _results(path, results_path)
        return _ReceiptCheck(
            path, receipt=receipt, results=_check_results(receipt, results) if results is not None else ""
        )
    except ReceiptError as error:
        return _ReceiptCheck(path, error=str(error))


def _show_one(one: _ReceiptCheck, key: bytes | None, whose: str, *, named: bool) -> None:
    shown = console(TABLE_WIDTH)

    def say(text: str) -> None:
        shown.print(many_lines(text), soft_wrap=True)

    if named:
        say(f"{one.path}:")
    if one.receipt is None:
        shown.file.flush()
        sys.stderr.write(f"error: {many_lines(one.error)}\n")
        return
    _show(one.receipt, shown, say)
    if one.results:
        say(one.results)
    if key is not None:
        say(f"signed with {whose}, {key.hex()}")
        if one.superseded:
            say(one.superseded)
        return
    say(
        f"signed with the key {one.receipt.public_key.hex()}. It was NOT checked that this is the host's key: anyone "
        "can sign with a key of their own. Give the host's key with --key, or get it from its server with --server"
    )


def _superseded(options: argparse.Namespace, receipt: Receipt) -> str:
    """Ask the server, if one is given, whether the host has superseded a receipt; empty if not.

    For runs that are not published, the server answers only their participants.
    """
    if options.server is None:
        return ""
    request = leaderboard_pb2.GetEntryRequest(run_id=receipt.run["run_id"])
    with connect(options.server, access_of(options)) as server:
        try:
            entry = call(leaderboard_pb2_grpc.LeaderboardStub(server.channel).GetEntry, request, server.address)
        except NotArramonError:  # The server has no leaderboard.
            return ""
        except RefusedError as error:
            if error.code is not grpc.StatusCode.NOT_FOUND:
                raise
            return ""
    return superseded_line(receipt.digest, entry)


def _host_key(options: argparse.Namespace) -> tuple[bytes | None, str]:
    """Return the host's key and a description of it; None and "" if no key was given."""
    if options.key is not None:
        return receipts.read_key(options.key), "the key given"
    if options.server is None:
        return None, ""
    with connect(options.server, access_of(options)) as server:
        if not server.info.public_key:
            raise ReceiptError(f"the server at {options.server} has no key and does not sign receipts")
        return server.info.public_key, f"the key of {options.server}"


def _results(receipt: Path, named: Path | None) -> Mapping[str, Any] | None:
    """Return the results file's content; None if none was named and none is beside the receipt."""
    path = named or receipt.with_name(receipt.name.removesuffix(receipts.SUFFIX) + ".json")
    if named is None and (path == receipt or not path.exists()):
        return None
    content = receipts.read_file(path, "results file")
    if not (isinstance(content, dict) and isinstance(content.get("run"), dict) and "metrics" in content):
        raise ReceiptError(f"{path} is not a results file: it has no run and no metrics")
    if not isinstance(content.get("actions", {}), dict):
        raise ReceiptError(f"{path} is not a results file: its actions are not listed by episode")
    return {**content, "path": path}


def _check_results(receipt: Receipt, results: Mapping[str, Any]) -> str:
    """Compare this client's results file with the receipt; return a description of what was checked.

    Raises:
        ReceiptError: if anything differs; the message lists every difference.
    """
    path, run_id = results["path"], results["run"].get("run_id")
    if run_id != receipt.run["run_id"]:
        raise ReceiptError(f"{path} is for run {run_id}, but the receipt is for run {receipt.run['run_id']}")
    actions = {episode_id: _digits(path, sent) for episode_id, sent in results.get("actions", {}).items()}
    compared = receipts.compare_actions(receipt, actions)
    differences = list(compared.differences)
    corrected = bool(receipt.content.get("revision"))
    if results["metrics"] != receipt.content["scores"] and not corrected:
        differences.insert(0, f"{path} has different scores than the receipt")
    episodes = len(receipt.episodes)
    same = f"in {compared.same} of {episodes} episodes the actions match those that this client sent"
    unknown = episodes - compared.same - len(compared.differences)
    if unknown:
        same += f", for {unknown if compared.differences else 'the others'} it has no actions"
    if len(differences) > 1:
        differences.append(f"{path}: {same}")
    if differences:
        raise ReceiptError("\n".join(differences))
    scores = "the scores are those before the host's corrections" if corrected else "the scores match"
    return f"{path}: {scores}; {same}"


def _digits(path: Path, sent: object) -> list[int]:
    if not (isinstance(sent, str) and set(sent) <= set("0123")):
        raise ReceiptError(f"{path} is not a results file: its actions are not strings of the digits 0 to 3")
    return [int(digit) for digit in sent]


def _show(receipt: Receipt, shown: Console, say: Callable[[str], None]) -> None:
    run, content = receipt.run, receipt.content
    rows = [
        evaluation_pb2.Row(
            name=one_line(name),
            scores=[
                evaluation_pb2.Score(metric=one_line(metric), **{end: values[end] for end in ("mean", "low", "high")})
                for metric, values in scores.items()
            ],
        )
        for name, scores in content["scores"].items()
    ]
    agent, split, language = (one_line(run[name]) for name in ("agent", "split", "language"))
    of = evaluation_pb2.Run(agent=agent, split=split, language=language, episodes=len(receipt.episodes))
    shown.print(score_table(evaluation_pb2.Report(run=of, rows=rows)))
    causes = ", ".join(f"{number} {cause}" for cause, number in sorted(content["causes"].items()))
    limits = content["limits"]
    clocks = (
        f"{limits['step_seconds']:g} s per step, {limits['bank_seconds']:g} s in the bank"
        if limits["step_seconds"]
        else "no clocks"
    )
    steps = f"{content['steps']} steps; " if "steps" in content else ""  # A hidden split's receipt does not reveal it.
    lines = [
        content["score_signature"],
        f"run {run['run_id']} of {run['participant']}, {run['state'].lower()}",
        f"from {run['created_at']} to {run['ended_at'] or 'an unknown time'}",
        f"{steps}{clocks}; episodes ended: {causes}; offered again: {content['reoffers']}",
    ]
    if run.get("code"):
        lines.append(f"code: {', '.join(map(str, run['code'].values()))}")
    if content.get("epoch"):
        lines.append(f"epoch with the commitment {content['epoch']}")
    lines += signed_corrections(content)
    for line in lines:
        say(one_line(line, 5000))
