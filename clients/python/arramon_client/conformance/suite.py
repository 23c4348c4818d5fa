"""Checks, their results, and their execution one by one, each with separate runs that are cancelled afterwards."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import grpc

from arramon_client.conformance.assertions import Skipped, Violation
from arramon_client.conformance.target import Target
from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.transport.incoming import details_of


@dataclass(frozen=True, slots=True)
class Check:
    """One check of the protocol's contract.

    Attributes:
        name: the group and the check, for example "steps.repeat".
        promise: the checked promise of the contract, in one line.
        runs: maximum number of runs that the check creates.
        work: function that returns if the promise is kept, and raises Violation or Skipped otherwise.
    """

    name: str
    promise: str
    runs: int
    work: Callable[[Target], None]


def check(name: str, *, runs: int = 0) -> Callable[[Callable[[Target], None]], Check]:
    """Return a decorator that turns a function into a check; the first line of its docstring is the promise."""

    def make(work: Callable[[Target], None]) -> Check:
        promise = (work.__doc__ or "").strip().partition("\n")[0].rstrip(".")
        return Check(name, promise, runs, work)

    return make


class CheckOutcome(Enum):
    """Outcome of a check."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """Result of one check; `reason` says why it failed or was skipped, and is empty if it passed."""

    check: Check
    outcome: CheckOutcome
    reason: str
    seconds: float


def run_checks(target: Target, checks: Sequence[Check]) -> Iterator[CheckResult]:
    """Run checks in order, and yield each result once the check's runs are cancelled."""
    for each in checks:
        started = time.monotonic()
        try:
            outcome, reason = _outcome(each, target)
        finally:
            problems = target.clean_up()
        if problems and outcome is not CheckOutcome.FAILED:
            outcome, reason = CheckOutcome.FAILED, "; ".join(problems)
        yield CheckResult(each, outcome, reason, time.monotonic() - started)


def select(checks: Sequence[Check], names: Sequence[str]) -> list[Check]:
    """Return the checks with these names or in these groups; all checks if there are no names.

    Raises:
        UsageError: if no check or group has one of the names.
    """
    known = {word for each in checks for word in (each.name, each.name.partition(".")[0])}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise UsageError(f"there is no check or group {unknown[0]!r}, expected some of {', '.join(sorted(known))}")
    return [each for each in checks if not names or {each.name, each.name.partition(".")[0]} & set(names)]


def _outcome(each: Check, target: Target) -> tuple[CheckOutcome, str]:
    try:
        each.work(target)
    except Skipped as skipped:
        return CheckOutcome.SKIPPED, str(skipped)
    except (Violation, ArramonClientError) as violation:
        return CheckOutcome.FAILED, str(violation)
    except grpc.RpcError as error:
        return CheckOutcome.FAILED, f"the server answered {error.code().name}: {details_of(error) or 'no message'}"
    return CheckOutcome.PASSED, ""
