"""Faults in what a server tells of itself, of accounts and of runs."""

from collections.abc import Iterable
from typing import Any

import grpc

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA
from arramon.v1 import evaluation_pb2 as pb
from tests.conformance.breakers.faults import answers, clears, sets
from tests.conformance.forwarder import Fault, Metadata, Refusal, Stream, Unary


def shared_memory_first(info: pb.ServerInfo) -> None:
    offered = list(info.encodings)
    del info.encodings[:]
    info.encodings.extend(offered[::-1])


def no_stranger(request: Any, call: Unary) -> Any:
    if "authorization" not in dict(call.metadata):
        raise Refusal(grpc.StatusCode.UNAUTHENTICATED, "no token was sent")
    return call.forward(request)


def any_version(metadata: Metadata) -> Metadata:
    return (*(pair for pair in metadata if pair[0] != PROTOCOL_METADATA), (PROTOCOL_METADATA, str(PROTOCOL)))


def earliest_first(request: Any, call: Unary) -> Any:
    if call.method != "ListRuns":
        return call.forward(request)
    two = call.forward(pb.ListRunsRequest(page_size=2))
    if request.page_token == "swapped":
        return pb.ListRunsResponse(runs=two.runs[:1], next_page_token=two.next_page_token)
    return pb.ListRunsResponse(runs=two.runs[1:], next_page_token="swapped")


def named_are_reversed(request: Any, call: Unary) -> Any:
    if call.method == "CreateRun":
        named = request.episode_ids[::-1]
        del request.episode_ids[:]
        request.episode_ids.extend(named)
    return call.forward(request)


def first_named_alone(request: Any, call: Unary) -> Any:
    if call.method == "CreateRun":
        del request.episode_ids[1:]
    return call.forward(request)


def always_the_first_page(request: Any, call: Unary) -> Any:
    if call.method == "ListRuns":
        request.page_token = ""
    return call.forward(request)


def renamed(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    if event.WhichOneof("event") == "observation" and stream.opening.max_episodes == 2:
        event.observation.episode_id += "-other"
    return (event,)


INFORMATION = [
    ("information.server", answers("GetServerInfo", sets(version="")), "the version is empty"),
    ("information.server", answers("GetServerInfo", sets(public_key=b"short")), "the length of the public key .* is 5"),
    ("information.splits", answers("GetServerInfo", lambda info: sets(data_hash="x")(info.splits[0])), "data hash 'x'"),
    (
        "information.splits",
        answers("GetServerInfo", lambda info: info.splits.add().CopyFrom(info.splits[0])),
        "two splits have the same name",
    ),
    (
        "information.hidden",
        answers("GetServerInfo", lambda info: [s.sensors.append("pose") for s in info.splits if s.hidden]),
        "the hidden split 'secret' offers pose",
    ),
    ("information.encodings", answers("GetServerInfo", shared_memory_first), "ENCODING_SHARED is not the last"),
    ("information.encodings", answers("GetServerInfo", clears("image_sizes")), r"the image sizes are \[\]"),
    ("information.open", Fault(unary=no_stranger), "answered UNAUTHENTICATED: no token was sent"),
    ("version.refused", Fault(metadata=any_version), "GetServerInfo with protocol 2 was accepted"),
    ("account.quotas", answers("GetAccount", clears("quotas")), r"the list of splits with a quota is \[\]"),
    ("account.quotas", answers("GetAccount", sets(role=pb.ROLE_ANONYMOUS)), "the role is ROLE_ANONYMOUS for a caller"),
]

RUNS = [
    ("runs.created", answers("CreateRun", sets(data_hash="")), "data_hash of a new run is ''"),
    ("runs.created", answers("CreateRun", sets(state=pb.RUN_STATE_COMPLETE)), "state of a new run is 2, expected 1"),
    ("runs.created", answers("CreateRun", sets(created_at="yesterday")), "created_at is 'yesterday'"),
    ("runs.created", answers("GetRun", sets(agent="another")), "the run as GetRun returns it"),
    ("runs.account", answers("CreateRun", sets(participant="somebody")), "participant of the run is 'somebody'"),
    ("runs.listed", answers("ListRuns", clears("runs", "next_page_token")), "the latest 0 runs lack"),
    ("runs.listed", Fault(unary=always_the_first_page), "the pages list a run twice"),
    ("runs.listed", Fault(unary=earliest_first), "an earlier run is listed before a later one"),
    ("runs.order", Fault(tells=renamed), "expected it among them"),
    ("runs.chosen", Fault(unary=named_are_reversed), "the list of episodes played is"),
    ("runs.chosen", Fault(unary=first_named_alone), "the number of episodes of a run of 2 named ones is 1, expected 2"),
    ("runs.arguments", answers("CreateRun", clears("agent_arguments")), r"the list of the agent's arguments is \[\]"),
    ("runs.code", answers("CreateRun", clears("code")), "the code's url is ''"),
]
