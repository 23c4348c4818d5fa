"""Faults in how episodes and runs end, in reports and receipts."""

from collections.abc import Iterable
from typing import Any

import grpc
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from tests.conformance.breakers.faults import acts, again, answers, clears, drops, events, mirrored, sets, twice
from tests.conformance.forwarder import Fault, Stream, Unary


def another_cause(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    """The end of an episode is told again, with another cause."""
    kind = event.WhichOneof("event")
    if kind == "episode_ended":
        stream.own["ended"] = again = pb.Event()
        again.CopyFrom(event)
        again.episode_ended.cause = types_pb2.CAUSE_AGENT_FINISHED
    elif kind == "observation" and event.observation.step and "ended" in stream.own:
        return (stream.own.pop("ended"), event)
    return (event,)


def cancelled_again(request: Any, call: Unary) -> Any:
    try:
        return call.forward(request)
    except grpc.RpcError:
        if call.method != "CancelRun":
            raise
        return pb.Run()


def signed_by_another(receipt: pb.Receipt) -> None:
    key = Ed25519PrivateKey.generate()
    receipt.signature, receipt.public_key = key.sign(receipt.payload), key.public_key().public_bytes_raw()


class OtherScores:
    """Changes the scores of every second report."""

    def __init__(self) -> None:
        self._reports = 0

    def __call__(self, report: pb.Report) -> None:
        self._reports += 1
        if self._reports % 2 == 0:
            report.rows[0].scores[0].mean += 0.5


RESULTS = [
    ("results.ended", drops("run_ended"), "the stream ended without `run_ended`"),
    ("results.ended", Fault(tells=twice("run_ended")), "after `run_ended` the stream sent run_ended"),
    ("results.ended", Fault(tells=twice("episode_ended")), r"the list of episodes_ended is \[1, 1"),
    ("results.ended", events("episode_ended", sets(cause=5)), "a forfeited episode ended with another cause"),
    ("results.ended", events("run_ended", lambda over: sets(state=1)(over.run)), "the run is 'RUN_STATE_RUNNING'"),
    ("results.ended", events("run_ended", lambda over: clears("causes")(over.run)), "the run's causes is {}"),
    ("results.ended", answers("GetRun", sets(steps=0)), "the run as GetRun returns it"),
    ("results.one_cause", Fault(tells=another_cause), "after its end the episode was answered by episode_ended"),
    ("results.one_cause", answers("GetRun", sets(episodes_ended=2)), "episodes_ended is 2, expected 1"),
    ("results.one_cause", answers("GetRun", lambda run: run.causes.update(TIME_LIMIT=1)), "the run's causes is"),
    ("results.cancelled", answers("CancelRun", sets(episodes=0)), "the number of episodes is 0, expected 1"),
    ("results.cancelled", answers("CancelRun", sets(state=1)), "the state of the run is 'RUN_STATE_RUNNING'"),
    ("results.cancelled", Fault(unary=cancelled_again), "CancelRun of a run that is over was accepted"),
    ("results.over", drops("run_ended"), "the stream sent its end, expected run_ended"),
    ("results.over", Fault(tells=twice("run_ended")), "after `run_ended` the stream went on"),
    ("results.report", answers("GetReport", sets(signature="a\nb")), "the report's signature has several lines"),
    ("results.report", answers("GetReport", lambda report: report.rows.pop()), "the list of rows is"),
    (
        "results.report",
        answers("GetReport", lambda report: sets(low=0.5, mean=0.25)(report.rows[0].scores[0])),
        "of turn 1 is 0.25, in 0.5 to .*, expected it within its interval",
    ),
    (
        "results.report",
        answers("GetReport", clears("episodes")),
        "the number of episodes in the report is 0, expected 1",
    ),
    ("results.report", answers("GetReport", lambda r: sets(steps=9)(r.episodes[0])), "the steps of episode .* is 9"),
    ("results.receipt", answers("GetReceipt", sets(signature=bytes(64))), "was altered"),
    ("results.receipt", answers("GetReceipt", signed_by_another), "the receipt is signed with the key"),
    ("results.receipt", acts(mirrored), "the receipt's actions differ from those that this client sent"),
    (
        "results.deterministic",
        events("observation", lambda seen: sets(x=seen.pose.x + seen.step)(seen.pose), again),
        r"gave another observation from step \[1\] on",
    ),
    ("results.deterministic", answers("GetReport", OtherScores()), "the same actions gave other scores"),
]
