"""Every check passes on a correct server, and fails for its own reason on one that breaks its promise."""

import re
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.conformance.checks import CHECKS
from arramon_client.conformance.suite import Check, CheckOutcome, CheckResult, run_checks
from arramon_client.conformance.target import Target, choose_target
from arramon_client.transport.access import Access
from arramon_client.transport.connection import METADATA, connect
from tests.conformance.breakers import Breaker, breakers
from tests.conformance.forwarder import Fault, Forwarder, Refusal, Unary

BY_NAME = {check.name: check for check in CHECKS}


def results(forwarder: Forwarder, access: Access, fault: Fault, *checks: Check) -> list[CheckResult]:
    """The results of checks on a server with this fault; none of its runs goes on afterwards."""
    forwarder.install(fault)
    with connect(forwarder.address, access) as server:
        done = list(run_checks(choose_target(server, None, None, 60.0), checks))
        forwarder.install(Fault())
        listed = server.stub.ListRuns(pb.ListRunsRequest(page_size=100), metadata=METADATA).runs
        assert pb.RUN_STATE_RUNNING not in {run.state for run in listed}
        return done


def test_a_correct_server_passes_every_check(forwarder: Forwarder, access: Access) -> None:
    assert [
        (result.check.name, result.reason)
        for result in results(forwarder, access, Fault(), *CHECKS)
        if result.outcome is not CheckOutcome.PASSED
    ] == []


def test_an_interrupted_check_leaves_no_run_behind(forwarder: Forwarder, access: Access) -> None:
    created: list[str] = []

    def interrupt(target: Target) -> None:
        created.append(target.create().run_id)
        raise KeyboardInterrupt

    forwarder.install(Fault())
    with connect(forwarder.address, access) as server:
        with pytest.raises(KeyboardInterrupt):
            list(run_checks(choose_target(server, None, None, 60.0), [Check("none", "None", 1, interrupt)]))
        run = server.stub.GetRun(pb.GetRunRequest(run_id=created[0]), metadata=METADATA)
    assert run.state == pb.RUN_STATE_CANCELLED


def test_a_run_that_cannot_be_cancelled_fails_its_check(forwarder: Forwarder, access: Access) -> None:
    def unary(request: Any, call: Unary) -> Any:
        if call.method == "CancelRun":
            raise Refusal(grpc.StatusCode.INTERNAL, "not today")
        return call.forward(request)

    forwarder.install(Fault(unary=unary))
    with connect(forwarder.address, access) as server:
        target = choose_target(server, None, None, 60.0)
        (result,) = run_checks(target, [BY_NAME["steps.repeat"]])
        forwarder.install(Fault())
        for run in server.stub.ListRuns(pb.ListRunsRequest(page_size=1), metadata=METADATA).runs:
            target.cancel(run)
    assert result.outcome is CheckOutcome.FAILED
    assert re.fullmatch(r"run \w+ could not be cancelled: INTERNAL: not today", result.reason)


def test_every_check_has_a_fault_that_breaks_it() -> None:
    assert {breaker.check for breaker in breakers("")} == set(BY_NAME)


def test_names_and_promises_are_unique_lines() -> None:
    assert len(BY_NAME) == len(CHECKS)
    assert len({check.promise for check in CHECKS}) == len(CHECKS)
    for check in CHECKS:
        assert re.fullmatch(r"[a-z]+\.[a-z_]+", check.name)
        assert check.promise
        assert "\n" not in check.promise


@pytest.mark.parametrize("number", range(len(breakers(""))), ids=lambda n: f"{breakers('')[n].check}-{n}")
def test_a_broken_promise_is_detected(forwarder: Forwarder, access: Access, token: str, number: int) -> None:
    breaker: Breaker = breakers(token)[number]
    (result,) = results(forwarder, access, breaker.fault, BY_NAME[breaker.check])
    assert result.outcome is CheckOutcome.FAILED
    assert re.search(breaker.pattern, result.reason), result.reason
