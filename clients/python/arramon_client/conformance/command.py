"""The command `arramon-client conformance`: check a server against the protocol's contract, and print the results."""

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import grpc
from rich.console import Console

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.commands.base import ERROR, SUCCESS, run
from arramon_client.conformance.checks import CHECKS
from arramon_client.conformance.suite import Check, CheckOutcome, CheckResult, run_checks, select
from arramon_client.conformance.target import Target, choose_target
from arramon_client.errors import UsageError
from arramon_client.files import write_whole
from arramon_client.printable import many_lines, to_json
from arramon_client.transport.access import access_of, add_access
from arramon_client.transport.connection import connect, explain

WORDS = {CheckOutcome.PASSED: "pass", CheckOutcome.FAILED: "FAIL", CheckOutcome.SKIPPED: "skip"}
"""Prefix of a result's line, by outcome."""


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 if no check failed, 1 if one did, 2 for wrong usage."""
    parser = argparse.ArgumentParser(
        prog="arramon-client conformance",
        allow_abbrev=False,
        description="Check that a server keeps the protocol's contract. Runs are created, and cancelled afterwards.",
        epilog="exit status: 0 no check failed; 1 a check failed, or the server cannot be reached; 2 wrong usage, or a "
        "quota too small for the runs needed; 130 interrupted",
    )
    add = parser.add_argument
    add("--server", required=True, metavar="ADDR", help="host:port or unix:/path")
    add("--split", metavar="NAME", help="split for the runs (default: an open one)")
    add("--lang", metavar="L", help="language of the runs (default: the one with the most episodes)")
    add("--only", default="", metavar="NAMES", help="run only these checks or groups, separated by commas")
    add("--timeout", type=_seconds, default=60.0, metavar="S", help="seconds to wait for each answer (default: 60)")
    add("--json", type=Path, metavar="FILE", help="also write the results to this file as JSON")
    add_access(parser)
    return run(parser, argv, _work)


def _work(options: argparse.Namespace) -> int:
    checks = select(CHECKS, [name for name in options.only.split(",") if name])
    console = Console(width=200, markup=False, highlight=False, emoji=False)
    with connect(options.server, access_of(options)) as server:
        target = choose_target(server, options.split, options.lang, options.timeout)
        needed, at_once = _runs(checks)
        info = server.info
        _say(console, f"server {info.version}, protocol {info.protocol}; split {target.split.name}, {target.language}")
        _say(
            console,
            f"{len(checks)} checks, which create up to {needed} runs, at most {at_once} at once, and cancel them",
        )
        _check_quota(target, checks)
        results = []
        for result in run_checks(target, checks):
            results.append(result)
            _say(console, f"{WORDS[result.outcome]}  {result.check.name}: {result.check.promise}")
            if result.reason:
                _say(console, f"      {result.reason}")
    counts = Counter(result.outcome for result in results)
    _say(console, ", ".join(f"{counts[outcome]} {outcome.value}" for outcome in CheckOutcome))
    if options.json is not None:
        write_whole(options.json, to_json(_content(target, results)))
    return ERROR if counts[CheckOutcome.FAILED] else SUCCESS


def _check_quota(target: Target, checks: Sequence[Check]) -> None:
    """Check, before any run is created, that the account's quota is sufficient for the checks.

    Raises:
        UsageError: if it is not.
        ArramonClientError: if the server does not answer.
    """
    needed, at_once = _runs(checks)
    if not needed:
        return
    try:
        account = target.call("GetAccount", pb.GetAccountRequest())
    except grpc.RpcError as error:
        raise explain(error, target.server.address) from error
    for quota in account.quotas:
        if quota.split != target.split.name:
            continue
        for limit, used, wanted, name in (
            (quota.runs_per_day, quota.runs_today, needed, "runs_per_day"),
            (quota.runs_in_all, quota.runs, needed, "runs_in_all"),
            (quota.runs_at_once, quota.running, at_once, "runs_at_once"),
        ):
            if limit and limit - used < wanted:
                raise UsageError(
                    f"the checks need {wanted} runs on split {quota.split!r}, and the quota {name} leaves "
                    f"{max(limit - used, 0)} of {limit}: ask the host for more, or run fewer checks with --only"
                )


def _runs(checks: Sequence[Check]) -> tuple[int, int]:
    """Return the maximum number of runs that checks create, in total and at once."""
    return sum(check.runs for check in checks), max((check.runs for check in checks), default=0)


def _content(target: Target, results: Sequence[CheckResult]) -> dict[str, object]:
    """Return the results as plain data."""
    return {
        "server": target.server.address,
        "version": target.info.version,
        "protocol": target.info.protocol,
        "split": target.split.name,
        "language": target.language,
        "checks": [
            {
                "name": result.check.name,
                "promise": result.check.promise,
                "outcome": result.outcome.value,
                "reason": result.reason,
                "seconds": round(result.seconds, 3),
            }
            for result in results
        ],
    }


def _say(console: Console, text: str) -> None:
    console.print(many_lines(text, 2000), markup=False, highlight=False, soft_wrap=True)


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 86_400.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return seconds
