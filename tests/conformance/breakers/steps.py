"""Faults in how actions are taken and observed."""

from collections.abc import Iterable

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from tests.conformance.breakers.faults import acts, clears, events, mirrored, sets
from tests.conformance.forwarder import Fault, Refusal, Stream


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
