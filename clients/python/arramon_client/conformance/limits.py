"""Checks of limits: episodes per stream, steps per phase, clocks, and message sizes."""

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.conformance.assertions import expect, expect_equal, expect_refusal, need
from arramon_client.conformance.raw_stream import RawStream, forfeit
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import LEFT, Target
from arramon_client.transport.connection import MAX_MESSAGE_BYTES

MAX_STEPS = 1000
"""Highest step limit of a phase that is tested, by playing the phase to its end; an episode has four phases."""

PHASES = [(turn, phase) for turn in (1, 2) for phase in (types_pb2.PHASE_NAVIGATION, types_pb2.PHASE_ASSEMBLY)]
"""Turn and phase, in the order in which they are played."""


@check("limits.open_episodes", runs=1)
def open_episodes(target: Target) -> None:
    """A stream has at most `max_episodes` open episodes, gets a new one when one ends, and gets each one once."""
    run = target.create(episodes=3)
    target.check_bounded(run)
    started: list[str] = []
    open_now: set[str] = set()
    with target.play(run, 2) as stream:
        for event in stream.rest():
            kind = event.WhichOneof("event")
            if kind == "episode_started":
                started.append(event.episode_started.episode_id)
                open_now.add(started[-1])
                expect(len(open_now) <= 2, f"{len(open_now)} episodes are open on a stream that requested 2")
            elif kind == "episode_ended":
                open_now.discard(event.episode_ended.episode_id)
            elif kind == "observation":
                stream.send(forfeit(event.observation.episode_id))
    expect(len(set(started)) == len(started), "an episode was started twice on one stream, expected each once")
    expect_equal("the number of episodes that were offered", len(started), run.episodes)


@check("limits.max_episodes", runs=1)
def max_episodes(target: Target) -> None:
    """A stream that requests no episodes, or more than the server allows, is refused: INVALID_ARGUMENT."""
    run = target.create()
    for number in (0, target.info.max_episodes_per_stream + 1):

        def play(number: int = number) -> None:
            with target.play(run, number) as stream:
                stream.next("opened")

        expect_refusal(f"a stream with max_episodes {number}", play, grpc.StatusCode.INVALID_ARGUMENT)


@check("limits.steps", runs=1)
def steps(target: Target) -> None:
    """The step limit ends each phase, marked as forced, and finally the episode with CAUSE_STEP_LIMIT, not an error."""
    limit = target.info.limits.steps_per_phase
    need(limit <= MAX_STEPS, f"a phase has {limit} steps; a limit of at most {MAX_STEPS} would make it run")
    run = target.create()
    ended: list[tuple[int, int]] = []
    with target.play(run) as stream:
        _, _, seen = stream.begin()
        for turn, phase in PHASES:
            seen = _exhaust(stream, seen, limit)
            over = stream.next("phase_ended")
            ended.append((over.turn, over.phase))
            expect(over.forced, f"phase {phase} of turn {turn} was not ended by force, expected so after {limit} steps")
            if (turn, phase) != PHASES[-1]:
                seen = stream.next("observation")
                expect_equal("phase_step of the next phase", seen.phase_step, 0)
        over = stream.next("episode_ended")
    expect_equal("the list of phases that ended", ended, PHASES)
    name = types_pb2.Cause.Name(over.cause)
    expect(over.cause == types_pb2.CAUSE_STEP_LIMIT, f"the cause is {name}, expected CAUSE_STEP_LIMIT")


@check("limits.clocks", runs=1)
def clocks(target: Target) -> None:
    """With clocks, observations give the seconds left of step and bank, within the limits; without clocks, neither."""
    run = target.create()
    limits = run.limits
    with target.play(run) as stream:
        _, _, first = stream.begin()
        stream.act(first, LEFT)
        second = stream.observation()
    for seen in (first, second):
        what = f"step_seconds_left of step {seen.step}"
        for name in ("step_seconds_left", "bank_seconds_left"):
            is_said = "is" if seen.HasField(name) else "is not"
            expected = "is" if limits.step_seconds else "is not"
            expect(
                is_said == expected, f"{name} {is_said} in the observation, and step_seconds is {limits.step_seconds}"
            )
        left = seen.step_seconds_left
        expect(left <= limits.step_seconds, f"{what} is {left:g}, expected at most {limits.step_seconds:g}")
        bank = seen.bank_seconds_left
        expect(bank <= limits.bank_seconds, f"the bank has {bank:g} seconds, expected at most {limits.bank_seconds:g}")


@check("limits.message")
def message(target: Target) -> None:
    """A message larger than `max_message_bytes` is refused: RESOURCE_EXHAUSTED."""
    limit = target.info.max_message_bytes
    need(
        limit < MAX_MESSAGE_BYTES,
        f"max_message_bytes is {limit}; less than {MAX_MESSAGE_BYTES}, all that this client sends, would make it run",
    )
    request = pb.GetRunRequest(run_id="x" * limit)
    code = grpc.StatusCode.RESOURCE_EXHAUSTED
    expect_refusal(f"a message of {request.ByteSize()} bytes", lambda: target.call("GetRun", request), code)


def _exhaust(stream: RawStream, seen: pb.Observation, limit: int) -> pb.Observation:
    """Turn left until the phase's last step is sent; return the observation answered by it."""
    for _ in range(limit - 1):
        stream.act(seen, LEFT)
        seen = stream.next("observation")
    expect_equal("steps_left before the last step of a phase", seen.steps_left, 1)
    stream.act(seen, LEFT)
    return seen


CHECKS = (open_episodes, max_episodes, steps, clocks, message)
