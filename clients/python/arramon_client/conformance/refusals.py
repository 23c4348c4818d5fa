"""Checks of refusals: invalid requests are refused with the right status and a message, and create nothing."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.conformance.assertions import expect_refusal, need
from arramon_client.conformance.information import PRIVILEGED
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import AGENT, Target
from arramon_client.transport.access import Access, is_local
from arramon_client.transport.channel import open_channel
from arramon_client.transport.connection import CHANNEL_OPTIONS, METADATA

BAD, UNKNOWN = grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.NOT_FOUND

UNKNOWN_NAME = "no-such-thing"
"""A name of a split, language, sensor or run that no server has."""

WRONG_TOKEN = "arramon_conformance_not-a-token"  # noqa: S105 - not a real token
"""A token that no server has issued."""


@check("refusals.split")
def split(target: Target) -> None:
    """A run on a split that the server does not have is refused: NOT_FOUND."""
    _refuse_run(target, "a run on an unknown split", UNKNOWN, split=UNKNOWN_NAME, episodes=0)


@check("refusals.language")
def language(target: Target) -> None:
    """A run in a language that the split does not have is refused: NOT_FOUND."""
    _refuse_run(target, "a run in an unknown language", UNKNOWN, language=UNKNOWN_NAME)


@check("refusals.sensors")
def sensors(target: Target) -> None:
    """A run with a sensor that does not exist is refused: INVALID_ARGUMENT."""
    _refuse_run(target, "a run with an unknown sensor", BAD, sensors=[UNKNOWN_NAME])


@check("refusals.hidden_sensors")
def hidden_sensors(target: Target) -> None:
    """A run on a hidden split with a sensor that would reveal it is refused: INVALID_ARGUMENT."""
    for sensor in PRIVILEGED:
        _refuse_hidden(target, f"a run on a hidden split with the sensor {sensor!r}", sensors=[sensor])


@check("refusals.hidden_part")
def hidden_part(target: Target) -> None:
    """A run of a part of a hidden split is refused, as two parts would reveal an episode's score: INVALID_ARGUMENT."""
    hidden = target.hidden
    need(
        hidden is None or max(hidden.episodes.values()) > 1, "the hidden split has one episode; more would make it run"
    )
    _refuse_hidden(target, "a run of one episode of a hidden split", episodes=1)
    _refuse_hidden(target, "a run of a named episode of a hidden split", episode_ids=[UNKNOWN_NAME])


@check("refusals.agent")
def agent(target: Target) -> None:
    """A run of an agent without a name is refused: INVALID_ARGUMENT."""
    _refuse_run(target, "a run of an agent without a name", BAD, agent="")


@check("refusals.episodes")
def episodes(target: Target) -> None:
    """A run of more episodes than the split has is refused: INVALID_ARGUMENT."""
    number = target.available + 1
    _refuse_run(target, f"a run of {number} episodes of {target.available}", BAD, episodes=number)


@check("refusals.chosen")
def chosen(target: Target) -> None:
    """A run of a named episode that the split does not have is refused: NOT_FOUND."""
    hidden = f"the split {target.split.name!r} is hidden"
    need(not target.split.hidden, f"{hidden}, where episodes cannot be named; an open one would make it run")
    _refuse_run(target, "a run of an unknown episode", UNKNOWN, episode_ids=[UNKNOWN_NAME])


@check("refusals.arguments")
def arguments(target: Target) -> None:
    """An agent's argument is refused if its name is not an identifier or given twice, or its value is too long."""
    right = pb.AgentArgument(name="beam", value="4")
    for what, given in (
        ("an argument whose name is no identifier", [pb.AgentArgument(name="a beam", value="4")]),
        ("an argument that comes twice", [right, right]),
        ("a value of 201 characters", [pb.AgentArgument(name="beam", value="4" * 201)]),
        ("a value of two lines", [pb.AgentArgument(name="beam", value="4\n5")]),
        ("17 arguments", [pb.AgentArgument(name=f"beam_{number}") for number in range(17)]),
    ):
        _refuse_run(target, f"a run of an agent with {what}", BAD, agent_arguments=given)


@check("refusals.code")
def code(target: Target) -> None:
    """An agent's code with an address that is not http, a short commit or an image without a digest is refused."""
    url = "https://example.org/agent"
    for what, given in (
        ("an address of another kind", pb.Code(url="ftp://example.org/agent")),
        ("an address with a password", pb.Code(url="https://somebody:password@example.org/agent")),
        ("an abbreviated commit", pb.Code(url=url, commit="0123456")),
        ("a commit without an address", pb.Code(commit="0123456789" * 4)),
        ("an image without a digest", pb.Code(image="agent:latest")),
    ):
        _refuse_run(target, f"a run of code with {what}", BAD, code=given)


@check("refusals.unknown_run")
def unknown_run(target: Target) -> None:
    """Any request for a run that does not exist is refused: NOT_FOUND."""
    requests: tuple[tuple[str, Any], ...] = (
        ("GetRun", pb.GetRunRequest(run_id=UNKNOWN_NAME)),
        ("CancelRun", pb.CancelRunRequest(run_id=UNKNOWN_NAME)),
        ("GetReport", pb.GetReportRequest(run_id=UNKNOWN_NAME)),
        ("GetReceipt", pb.GetReceiptRequest(run_id=UNKNOWN_NAME)),
    )
    for method, request in requests:
        expect_refusal(f"{method} of an unknown run", partial(target.call, method, request), UNKNOWN)
    _refuse_stream(target, "Play of an unknown run", UNKNOWN, run_id=UNKNOWN_NAME)


@check("refusals.page")
def page(target: Target) -> None:
    """A page of more than 1000 runs is refused: INVALID_ARGUMENT."""
    request = pb.ListRunsRequest(page_size=1001)
    expect_refusal("a page of 1001 runs", lambda: target.call("ListRuns", request), BAD)


@check("refusals.first_message", runs=1)
def first_message(target: Target) -> None:
    """A stream whose first message is not `open`, or that sends a second `open`, is refused: INVALID_ARGUMENT."""

    def act_first() -> None:
        with target.play_raw(pb.PlayRequest(actions=pb.ActionBatch())) as stream:
            list(stream.rest())

    run = target.create()

    def open_twice() -> None:
        with target.play(run) as stream:
            stream.begin()
            stream.send_raw(pb.PlayRequest(open=pb.Open(run_id=run.run_id, max_episodes=1)))
            stream.event()

    expect_refusal("a stream that starts with actions", act_first, BAD)
    expect_refusal("a second `open` on a stream", open_twice, BAD)


@check("refusals.image_size", runs=1)
def image_size(target: Target) -> None:
    """A stream that requests an image size that is not offered is refused: INVALID_ARGUMENT."""
    size = max(target.info.image_sizes, default=0) + 1
    _refuse_stream(target, f"a stream with images of {size} pixels", BAD, image_size=size)


@check("refusals.encoding", runs=1)
def encoding(target: Target) -> None:
    """A stream that requests an encoding that is not offered is refused: INVALID_ARGUMENT."""
    known = (*types_pb2.Encoding.values(), max(types_pb2.Encoding.values()) + 1)
    number = next(value for value in known[1:] if value not in target.info.encodings)
    _refuse_stream(target, f"a stream with the encoding {number}", BAD, encoding=number)


@check("refusals.quality", runs=1)
def quality(target: Target) -> None:
    """A JPEG quality above 100, or with another encoding, is refused: INVALID_ARGUMENT."""
    jpeg = types_pb2.ENCODING_JPEG
    others = [each for each in target.info.encodings if each != jpeg]
    asked = ([(jpeg, 101)] if jpeg in target.info.encodings else []) + [(other, 90) for other in others[:1]]
    run = target.create()
    for encoding, number in asked:
        name = types_pb2.Encoding.Name(encoding)
        what = f"a stream with {name} and jpeg_quality {number}"
        _refuse_stream(target, what, BAD, run_id=run.run_id, encoding=encoding, jpeg_quality=number)


@check("refusals.unfinished", runs=1)
def unfinished(target: Target) -> None:
    """The report and the receipt of a running run are refused: FAILED_PRECONDITION."""
    run = target.create()
    requests: tuple[tuple[str, Any], ...] = (
        ("GetReport", pb.GetReportRequest(run_id=run.run_id)),
        ("GetReceipt", pb.GetReceiptRequest(run_id=run.run_id)),
    )
    for method, request in requests:
        what = f"{method} of a run that is being played"
        expect_refusal(what, partial(target.call, method, request), grpc.StatusCode.FAILED_PRECONDITION)


@check("refusals.token")
def token(target: Target) -> None:
    """A token that the server has not issued is refused: UNAUTHENTICATED."""
    access = target.server.access
    is_safe = access.encrypts(target.server.address) or is_local(target.server.address)
    need(is_safe, "the connection is not encrypted, where tokens are not taken; --tls would make it run")
    _refuse_caller(target, "a token that was never issued", replace(access, token=WRONG_TOKEN))


@check("refusals.anonymous")
def anonymous(target: Target) -> None:
    """If the server requires tokens, a caller without one is refused: UNAUTHENTICATED."""
    address, access = target.server.address, target.server.access
    bare = replace(access, token="", tls=access.encrypts(address))
    with open_channel(address, bare, CHANNEL_OPTIONS) as channel:
        request = pb.GetServerInfoRequest()
        info = EvaluationStub(channel).GetServerInfo(request, timeout=target.timeout, metadata=METADATA)
    need(not info.anonymous, "the server lets callers without a token play; one that does not would make it run")
    _refuse_caller(target, "a caller without a token", bare)


def _refuse_run(target: Target, what: str, status: grpc.StatusCode, /, **fields: Any) -> None:
    """Check that a request for a run is refused if it differs from a valid one in these fields."""
    expect_refusal(what, lambda: target.create_raw(_request(target, **fields)), status)


def _request(target: Target, **fields: Any) -> pb.CreateRunRequest:
    right = {"agent": AGENT, "split": target.split.name, "language": target.language}
    return pb.CreateRunRequest(**{**right, **fields})


def _refuse_hidden(target: Target, what: str, **fields: Any) -> None:
    hidden = target.hidden
    need(hidden is not None, "the server has no hidden split; one would make it run")
    assert hidden is not None
    code = max(hidden.episodes, key=lambda each: hidden.episodes[each])
    _refuse_run(target, what, BAD, split=hidden.name, language=code, **fields)


def _refuse_stream(target: Target, what: str, code: grpc.StatusCode, **fields: Any) -> None:
    """Check that a stream is refused before `opened` if its `open` message differs from a valid one in these fields."""
    opening = {"max_episodes": 1, **fields}
    if "run_id" not in opening:
        opening["run_id"] = target.create().run_id

    def play() -> None:
        with target.play_raw(pb.PlayRequest(open=pb.Open(**opening))) as stream:
            stream.next("opened")

    expect_refusal(what, play, code)


def _refuse_caller(target: Target, what: str, access: Access) -> None:
    """Check that a caller is refused, in unary calls and on streams."""
    with open_channel(target.server.address, access, CHANNEL_OPTIONS) as channel:
        stub = EvaluationStub(channel)
        calls: tuple[tuple[str, Callable[[], Any]], ...] = (
            (
                "CreateRun",
                lambda: stub.CreateRun(_request(target, split=UNKNOWN_NAME), timeout=target.timeout, metadata=METADATA),
            ),
            ("Play", lambda: list(stub.Play(iter([pb.PlayRequest()]), timeout=target.timeout, metadata=METADATA))),
        )
        for method, work in calls:
            expect_refusal(f"{method} by {what}", work, grpc.StatusCode.UNAUTHENTICATED)


CHECKS = (
    split, language, sensors, hidden_sensors, hidden_part, agent, episodes, chosen, arguments, code,
    unknown_run,
    page, first_message,
    image_size, encoding, quality, unfinished, token, anonymous,
)  # fmt: skip
