"""For each check, a fault of the server that makes it fail, and the reason that the check must give."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import grpc
import numpy as np
import simplejpeg
import zstandard
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA, types_pb2
from arramon.v1 import evaluation_pb2 as pb
from tests.conformance.forwarder import Fault, Metadata, Refusal, Stream, Unary


class Breaker(NamedTuple):
    """A fault that makes a check fail with words that match a pattern."""

    check: str
    fault: Fault
    pattern: str


def answers(method: str, change: Callable[[Any], object]) -> Fault:
    """A fault that changes the answers of a unary method."""

    def unary(request: Any, call: Unary) -> Any:
        answer = call.forward(request)
        if call.method == method:
            change(answer)
        return answer

    return Fault(unary=unary)


def requests(method: str, **fields: Any) -> Fault:
    """A fault that puts other values into the requests of a unary method: what was wrong in them is not noticed."""

    def unary(request: Any, call: Unary) -> Any:
        if call.method == method:
            for name, value in fields.items():
                if value is None:
                    request.ClearField(name)
                elif isinstance(value, list):
                    request.ClearField(name)
                    getattr(request, name).extend(value)
                else:
                    setattr(request, name, value)
        return call.forward(request)

    return Fault(unary=unary)


def opens(**fields: Any) -> Fault:
    """A fault that puts other values into `open`."""

    def asks(request: pb.PlayRequest, _: Stream) -> Iterable[pb.PlayRequest]:
        if request.WhichOneof("message") == "open":
            for name, value in fields.items():
                setattr(request.open, name, value)
        return (request,)

    return Fault(asks=asks)


def acts(change: Callable[[list[pb.Act], Stream], object]) -> Fault:
    """A fault that changes the acts that reach the server."""

    def asks(request: pb.PlayRequest, stream: Stream) -> Iterable[pb.PlayRequest]:
        change(list(request.actions.acts), stream)
        return (request,)

    return Fault(asks=asks)


def events(kind: str, change: Callable[[Any], object], when: Callable[[Stream], bool] = lambda _: True) -> Fault:
    """A fault that changes the events of a kind that reach the client, on some streams."""

    def tells(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
        if event.WhichOneof("event") == kind and when(stream):
            change(getattr(event, kind))
        return (event,)

    return Fault(tells=tells)


def drops(kind: str) -> Fault:
    """A fault that swallows the events of a kind."""
    return Fault(tells=lambda event, _: () if event.WhichOneof("event") == kind else (event,))


def sets(**fields: Any) -> Callable[[Any], None]:
    """A change that sets fields."""

    def change(message: Any) -> None:
        for name, value in fields.items():
            setattr(message, name, value)

    return change


def clears(*names: str) -> Callable[[Any], None]:
    """A change that clears fields."""

    def change(message: Any) -> None:
        for name in names:
            message.ClearField(name)

    return change


def again(stream: Stream) -> bool:
    """Whether a stream is not the first."""
    return stream.number > 1


# Faults that take more than a change of one message.


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


def applied_again(sent: list[pb.Act], stream: Stream) -> None:
    """A repeated step is taken for the next one."""
    for act in sent:
        key = act.episode_id, act.step
        if key in stream.own:
            act.step += 1
        stream.own[key] = True


def step_ignored(sent: list[pb.Act], stream: Stream) -> None:
    """Each act is taken for an answer to the step at hand, whatever step it names."""
    for number, act in enumerate(sent):
        act.step = stream.own.get("step", 0) + number
    stream.own["step"] = stream.own.get("step", 0) + len(sent)


def missing_is_forward(sent: list[pb.Act], _: Stream) -> None:
    for act in sent:
        if act.WhichOneof("choice") is None:
            act.action = types_pb2.ACTION_FORWARD


def first_alone(sent: list[pb.Act], _: Stream) -> None:
    for act in sent[1:]:
        act.CopyFrom(sent[0])


def mirrored(sent: list[pb.Act], _: Stream) -> None:
    other = {types_pb2.ACTION_LEFT: types_pb2.ACTION_RIGHT, types_pb2.ACTION_RIGHT: types_pb2.ACTION_LEFT}
    for act in sent:
        if act.HasField("action"):
            act.action = other.get(act.action, act.action)


def changed_from_the_second_on(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    """Observations of a step that was observed before show something else."""
    if event.WhichOneof("event") == "observation":
        key = event.observation.episode_id, event.observation.step
        stream.own[key] = stream.own.get(key, 0) + 1
        event.observation.pose.x += stream.own[key] - 1
    return (event,)


def problem_ends_the_stream(event: pb.Event, _: Stream) -> Iterable[pb.Event]:
    if event.WhichOneof("event") == "problem":
        raise Refusal(grpc.StatusCode.ABORTED, "that was too much")
    return (event,)


def problem_is_an_answer(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    seen = stream.own.setdefault("seen", pb.Event())
    if event.WhichOneof("event") == "observation":
        seen.CopyFrom(event)
    return (seen,) if event.WhichOneof("event") == "problem" else (event,)


def same_episode(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    if event.WhichOneof("event") == "observation":
        event.observation.episode_id = stream.common.setdefault("episode", event.observation.episode_id)
    return (event,)


def too_many(event: pb.Event, _: Stream) -> Iterable[pb.Event]:
    if event.WhichOneof("event") != "episode_started":
        return (event,)
    more = [pb.Event(episode_started=pb.EpisodeStarted(episode_id=f"more-{number}")) for number in range(2)]
    return (event, *more)


def twice(kind: str) -> Callable[[pb.Event, Stream], Iterable[pb.Event]]:
    return lambda event, _: (event, event) if event.WhichOneof("event") == kind else (event,)


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


def no_past(event: pb.Event, _: Stream) -> Iterable[pb.Event]:
    return () if event.WhichOneof("event") == "observation" and event.observation.HasField("taken") else (event,)


def renamed(event: pb.Event, stream: Stream) -> Iterable[pb.Event]:
    if event.WhichOneof("event") == "observation" and stream.opening.max_episodes == 2:
        event.observation.episode_id += "-other"
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


def black_zstd(seen: pb.Observation) -> None:
    if seen.rgb.encoding == types_pb2.ENCODING_ZSTD:
        seen.rgb.data = zstandard.compress(bytes(seen.rgb.height * seen.rgb.width * 3))


def jpeg(subsampling: str, value: int) -> Callable[[pb.Observation], None]:
    def change(seen: pb.Observation) -> None:
        if seen.rgb.encoding == types_pb2.ENCODING_JPEG:
            pixels = np.full((seen.rgb.height, seen.rgb.width, 3), value, np.uint8)
            seen.rgb.data = simplejpeg.encode_jpeg(pixels, colorspace="RGB", colorsubsampling=subsampling)

    return change


def one_label(opened: pb.Opened) -> None:
    del opened.labels[1:]


def misplaced(seen: pb.Observation) -> None:
    if seen.rgb.encoding == types_pb2.ENCODING_SHARED:
        seen.rgb.place = 0


WRONG_STATUS = Fault(refuses=lambda _, details: (grpc.StatusCode.UNKNOWN, details))
NO_MESSAGE = Fault(refuses=lambda code, _: (code, ""))

REFUSALS = (
    "version.refused", "limits.max_episodes", "limits.message", "refusals.split", "refusals.language",
    "refusals.sensors", "refusals.hidden_sensors", "refusals.hidden_part", "refusals.agent",
    "refusals.chosen", "refusals.arguments", "refusals.code", "refusals.episodes",
    "refusals.unknown_run", "refusals.page", "refusals.first_message", "refusals.image_size", "refusals.encoding",
    "refusals.quality", "refusals.unfinished", "refusals.token", "refusals.anonymous", "results.cancelled",
)  # fmt: skip
"""Checks that expect refusals: each notices a wrong status, and a message that is empty."""


def breakers(token: str) -> list[Breaker]:
    """Return what breaks each check.

    Args:
        token: that the server takes.
    """

    def any_token(metadata: Metadata) -> Metadata:
        return (*(pair for pair in metadata if pair[0] != "authorization"), ("authorization", f"Bearer {token}"))

    return [
        *(Breaker(name, WRONG_STATUS, r"was refused with UNKNOWN \(.+\), expected [A-Z_]+$") for name in REFUSALS),
        *(Breaker(name, NO_MESSAGE, r"was refused with [A-Z_]+ and no message") for name in REFUSALS),
        *(Breaker(*each) for each in (*INFORMATION, *RUNS, *STEPS, *STREAMS, *LIMITS, *IMAGES, *ACCEPTED, *RESULTS)),
        Breaker("refusals.token", Fault(metadata=any_token), r"CreateRun by a token .* refused with NOT_FOUND"),
        Breaker("refusals.anonymous", Fault(metadata=any_token), r"CreateRun by a caller .* refused with NOT_FOUND"),
    ]


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

STEPS = [
    ("steps.numbered", events("observation", sets(step=1)), "the observation's step is 1, expected 0"),
    ("steps.numbered", events("observation", sets(steps_left=8)), "steps_left is 8, expected 7"),
    ("steps.numbered", events("observation", clears("instruction")), "has no instruction"),
    ("steps.repeat", acts(applied_again), "the step after the repeated action is 2, expected 1"),
    ("steps.repeat", Fault(tells=changed_from_the_second_on), "answered with another observation than before"),
    ("steps.repeat_in_batch", acts(applied_again), "the step after the repeated action is 2, expected 1"),
    ("steps.repeat_in_batch", Fault(tells=changed_from_the_second_on), "another observation than before"),
    ("steps.behind", acts(step_ignored), "the stream sent observation, expected problem"),
    ("steps.behind", Fault(tells=changed_from_the_second_on), "expected the first to stand"),
    (
        "steps.behind",
        events("problem", sets(code=pb.Problem.CODE_STEP_AHEAD)),
        "the problem is CODE_STEP_AHEAD, expected CODE_STEP_BEHIND",
    ),
    ("steps.ahead", acts(step_ignored), "the stream sent observation, expected problem"),
    ("steps.ahead", events("problem", clears("message")), "the problem CODE_STEP_AHEAD has no message"),
    ("steps.ahead", Fault(tells=problem_ends_the_stream), "the server answered ABORTED"),
    ("steps.bad_action", acts(missing_is_forward), "the stream sent observation, expected problem"),
    ("steps.bad_action", Fault(tells=problem_ends_the_stream), "the server answered ABORTED"),
    ("steps.not_yours", events("problem", clears("episode_id")), "the problem names the episode ''"),
    ("steps.batch", acts(first_alone), "the list of answers is"),
    (
        "steps.forfeit",
        events("episode_ended", sets(cause=2)),
        "the cause is CAUSE_STEP_LIMIT, expected CAUSE_FORFEITED",
    ),
    ("steps.turn", acts(mirrored), "the heading is 30 degrees, expected 330"),
    ("steps.turn", events("observation", lambda seen: sets(x=float(seen.step))(seen.pose)), "the place after a turn"),
    (
        "steps.forward",
        events("observation", lambda seen: sets(z=2.0 * seen.step)(seen.pose)),
        "FORWARD moved the agent",
    ),
]

STREAMS = [
    ("claims.opened", drops("opened"), "the stream sent episode_started, expected opened"),
    ("claims.opened", events("opened", lambda first: first.episode_ids.append("x")), "that a new player gets back"),
    ("claims.opened", events("episode_started", sets(language="xx")), "the episode's language is 'xx'"),
    ("claims.opened", events("episode_started", sets(step=5)), "the steps taken in a new episode is 5, expected 0"),
    ("claims.apart", Fault(tells=same_episode), "two streams hold the episode '.*' at once"),
    ("claims.apart", Fault(tells=problem_is_an_answer), "the stream sent observation, expected problem"),
    (
        "claims.live",
        events("opened", lambda first: first.episode_ids.append("theirs"), again),
        r"the list of episodes that an adopting stream got back is \['theirs'\]",
    ),
    ("claims.replaced", events("opened", clears("episode_ids"), again), "the list of episodes that came back is"),
    (
        "claims.replaced",
        Fault(ends=lambda _: [pb.Event(observation=pb.Observation(step=1))]),
        "the old stream played on, and was sent observation",
    ),
    ("resume.latest", events("opened", clears("episode_ids"), again), "the list of episodes that came back is"),
    (
        "resume.latest",
        events("episode_started", sets(step=0), again),
        "at which the episode came back is 0, expected 3",
    ),
    ("resume.latest", events("observation", sets(phase_step=0), again), "with another observation than its latest"),
    ("resume.recorded", answers("GetRun", sets(steps=2)), "the number of steps recorded is 2, expected 3"),
    ("resume.history", opens(history=False), "the action taken in observation 0 of the history is None, expected 1"),
    ("resume.history", events("observation", sets(phase_step=0), again), "observation 1 of the history is not the one"),
    ("resume.adopted", Fault(tells=no_past), "the action taken in observation 0 of the history is None"),
]

LIMITS = [
    ("limits.open_episodes", Fault(tells=too_many), "3 episodes are open on a stream that requested 2"),
    ("limits.open_episodes", Fault(tells=twice("episode_started")), "an episode was started twice"),
    ("limits.max_episodes", opens(max_episodes=1), "a stream with max_episodes 0 was accepted"),
    ("limits.steps", events("phase_ended", sets(forced=False)), "phase 1 of turn 1 was not ended by force"),
    ("limits.steps", events("episode_ended", sets(cause=1)), "CAUSE_AGENT_FINISHED, expected CAUSE_STEP_LIMIT"),
    ("limits.steps", events("observation", sets(steps_left=9)), "before the last step of a phase is 9, expected 1"),
    (
        "limits.clocks",
        events("observation", clears("bank_seconds_left")),
        "bank_seconds_left is not in the observation",
    ),
    ("limits.clocks", events("observation", sets(step_seconds_left=1e6)), "step_seconds_left of step 0 is 1e.06"),
    ("limits.message", requests("GetRun", run_id="short"), "was refused with NOT_FOUND .* expected RESOURCE_EXHAUSTED"),
]

IMAGES = [
    (
        "sensors.asked",
        events("observation", lambda seen: seen.pose.SetInParent()),
        "the list of sensors .* is .'pose'.",
    ),
    (
        "sensors.asked",
        events("observation", clears("depth")),
        r"the list of sensors in the observation is \['rgb', 'seg",
    ),
    ("sensors.asked", events("episode_started", lambda s: s.oracle.SetInParent()), "came with the oracle"),
    ("sensors.asked", events("opened", clears("labels")), "whether `opened` has labels is False, expected True"),
    ("sensors.oracle", events("episode_started", clears("oracle")), "the episode came without the oracle"),
    ("sensors.oracle", events("episode_started", lambda s: s.oracle.targets.pop()), "the number of targets is 1"),
    (
        "sensors.segmentation",
        events("opened", one_label),
        "a pixel has the number .*, expected",
    ),
    (
        "sensors.segmentation",
        events("opened", lambda first: sets(kind="")(first.labels[1])),
        "a label has no kind",
    ),
    ("images.raw", events("observation", lambda seen: sets(data=b"short")(seen.rgb)), "has 5 bytes, expected 49152"),
    (
        "images.raw",
        events("opened", sets(encoding=types_pb2.ENCODING_ZSTD)),
        "the encoding in `opened` is 2, expected 1",
    ),
    ("images.zstd", events("observation", black_zstd), r"\d+ values of rgb differ from those of ENCODING_RAW"),
    (
        "images.zstd",
        events("observation", lambda seen: sets(data=b"?")(seen.depth)),
        "a Zstandard image cannot be decoded",
    ),
    ("images.shared", events("observation", misplaced), r"\d+ values of rgb differ from those of ENCODING_RAW"),
    ("images.jpeg", events("observation", jpeg("444", 0)), "the JPEG's chroma is '444', expected '420'"),
    ("images.jpeg", events("observation", jpeg("420", 0)), "pixels differ from raw ones by"),
    ("images.jpeg", events("opened", sets(jpeg_quality=1)), "the JPEG quality in `opened` is 1, expected 95"),
    ("images.default", events("opened", sets(image_size=1)), r"encoding and size in `opened` is \(1, 1\)"),
    ("images.sizes", opens(image_size=0), "the image size in `opened` is 224, expected 128"),
]

ACCEPTED = [
    ("refusals.split", requests("CreateRun", split="tiny"), "a run on an unknown split was accepted"),
    ("refusals.language", requests("CreateRun", language="en"), "a run in an unknown language was accepted"),
    ("refusals.sensors", requests("CreateRun", sensors=[]), "a run with an unknown sensor was accepted"),
    ("refusals.hidden_sensors", requests("CreateRun", sensors=["rgb"]), "with the sensor 'segmentation' was accepted"),
    ("refusals.hidden_part", requests("CreateRun", episodes=0), "one episode of a hidden split was accepted"),
    ("refusals.agent", requests("CreateRun", agent="somebody"), "an agent without a name was accepted"),
    ("refusals.episodes", requests("CreateRun", episodes=1), "a run of 7 episodes of 6 was accepted"),
    ("refusals.hidden_part", requests("CreateRun", episode_ids=[], episodes=0), "one episode of a hidden split was"),
    ("refusals.chosen", requests("CreateRun", episode_ids=[]), "a run of an unknown episode was accepted"),
    ("refusals.arguments", requests("CreateRun", agent_arguments=[]), "whose name is no identifier was accepted"),
    ("refusals.code", requests("CreateRun", code=None), "with an address of another kind was accepted"),
    ("refusals.page", requests("ListRuns", page_size=1000), "a page of 1001 runs was accepted"),
    ("refusals.image_size", opens(image_size=0), "a stream with images of 225 pixels was accepted"),
    ("refusals.encoding", opens(encoding=0), "a stream with the encoding 5 was accepted"),
    ("refusals.quality", opens(jpeg_quality=0), "with ENCODING_JPEG and jpeg_quality 101 was accepted"),
]

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
