"""The command `arramon-client verify`: whether a receipt is what its host signed, and about what this client sent."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from arramon.v1 import evaluation_pb2
from arramon_client import receipts
from arramon_client.access import access_of, add_access
from arramon_client.commands import FINE, run
from arramon_client.connection import connect
from arramon_client.errors import ReceiptError
from arramon_client.receipts import Receipt
from arramon_client.results import TABLE_WIDTH, score_table

UNVOUCHED = 3
"""Exit status: the receipt is whole, but nobody has said whose the key is."""


def main(argv: Sequence[str]) -> int:
    """Runs the command and returns its exit status: 0 all is right, 1 it is not, 2 usage, 3 the key was not checked."""
    parser = argparse.ArgumentParser(
        prog="arramon-client verify",
        allow_abbrev=False,
        description="Checks a receipt: its signature, the host's key, and the actions that this client sent.",
        epilog="exit status: 0 all is right; 1 it is not, and what is not was said; 2 wrong usage; "
        "3 the receipt is whole, but no key was given to check its own against",
    )
    parser.add_argument("receipt", type=Path, metavar="RECEIPT", help="the file RUN.receipt.json")
    key = parser.add_mutually_exclusive_group()
    key.add_argument("--key", metavar="FILE|HEX", help="the host's public key: hexadecimal, or a file with it, or PEM")
    key.add_argument("--server", metavar="ADDR", help="ask the host's server for its key: host:port or unix:/path")
    parser.add_argument(
        "--results", type=Path, metavar="FILE", help="of the run (default: RUN.json beside the receipt)"
    )
    add_access(parser)
    return run(parser, argv, _verify)


def _verify(options: argparse.Namespace) -> int:
    receipt = receipts.read_receipt(options.receipt)
    key, whose = _host_key(options)
    if key is not None:
        receipts.check_key(receipt, key, whose)
    console = Console()
    console.width = max(console.width, TABLE_WIDTH)

    def say(text: str) -> None:
        console.print(text, markup=False, highlight=False, soft_wrap=True)

    results = _results(options)
    checked = _check_results(receipt, results) if results is not None else ""
    _show(receipt, console)
    if checked:
        say(checked)
    if key is not None:
        say(f"signed with {whose}, {key.hex()}")
        return FINE
    say(
        f"signed with the key {receipt.public_key.hex()}. Whether that is the host's was NOT checked: anybody can sign "
        "with a key of their own. Give the host's key with --key, or ask its server with --server"
    )
    return UNVOUCHED


def _host_key(options: argparse.Namespace) -> tuple[bytes | None, str]:
    """The key to check against, if there is one, and whose it is."""
    if options.key is not None:
        return receipts.read_key(options.key), "the key given"
    if options.server is None:
        return None, ""
    with connect(options.server, access_of(options)) as server:
        if not server.info.public_key:
            raise ReceiptError(f"the server at {options.server} has no key, and signs nothing")
        return server.info.public_key, f"the key of {options.server}"


def _results(options: argparse.Namespace) -> Mapping[str, Any] | None:
    """The results file's content; None where none was named and none lies beside the receipt."""
    path: Path = options.results or options.receipt.with_name(
        options.receipt.name.removesuffix(receipts.SUFFIX) + ".json"
    )
    if options.results is None and (path == options.receipt or not path.exists()):
        return None
    content = receipts.read_json(path, "results file")
    if not (isinstance(content, dict) and {"run", "metrics"} <= content.keys()):
        raise ReceiptError(f"{path} is no results file: it has no run and no metrics")
    return {**content, "path": path}


def _check_results(receipt: Receipt, results: Mapping[str, Any]) -> str:
    """Checks what this client wrote down against the receipt; says what was checked."""
    path, run_id = results["path"], results["run"].get("run_id")
    if run_id != receipt.run["run_id"]:
        raise ReceiptError(f"{path} is of run {run_id}, and the receipt of run {receipt.run['run_id']}")
    if results["metrics"] != receipt.content["scores"]:
        raise ReceiptError(f"{path} has other scores than the receipt")
    actions = {episode_id: _digits(path, sent) for episode_id, sent in results.get("actions", {}).items()}
    checked = receipts.check_actions(receipt, actions)
    return (
        f"{path}: the same scores; in {checked} of {len(receipt.episodes)} episodes the actions are those that this "
        "client sent" + ("" if checked == len(receipt.episodes) else ", of the others it knows none")
    )


def _digits(path: Path, sent: object) -> list[int]:
    if not (isinstance(sent, str) and set(sent) <= set("0123")):
        raise ReceiptError(f"{path} is no results file: its actions are not texts of the digits 0 to 3")
    return [int(digit) for digit in sent]


def _show(receipt: Receipt, console: Console) -> None:
    run, content = receipt.run, receipt.content
    rows = [
        evaluation_pb2.Row(
            name=name, scores=[evaluation_pb2.Score(metric=metric, **values) for metric, values in scores.items()]
        )
        for name, scores in content["scores"].items()
    ]
    shown = evaluation_pb2.Run(
        agent=run["agent"], split=run["split"], language=run["language"], episodes=len(receipt.episodes)
    )
    console.print(score_table(evaluation_pb2.Report(run=shown, rows=rows)))
    causes = ", ".join(f"{number} {cause}" for cause, number in sorted(content["causes"].items()))
    limits = content["limits"]
    clocks = (
        f"{limits['step_seconds']:g} s a step, {limits['first_step_seconds']:g} s for the first, "
        f"{limits['bank_seconds']:g} s in the bank"
        if limits["step_seconds"] or limits["bank_seconds"]
        else "no clocks"
    )
    for line in (
        content["score_signature"],
        f"run {run['run_id']} of {run['participant']}, {run['state'].lower()}",
        f"from {run['created_at']} to {run['ended_at'] or 'an unknown time'}",
        f"{content['steps']} steps; {clocks}; episodes ended: {causes}; offered again: {content['reoffers']}",
    ):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
