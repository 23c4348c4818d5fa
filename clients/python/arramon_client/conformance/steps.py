"""Checks of numbered steps: in order, repeated, ahead, behind, and with invalid actions."""

import math

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.conformance.assertions import expect, expect_equal
from arramon_client.conformance.raw_stream import RawStream, forfeit, without_clocks
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import FORWARD, LEFT, RIGHT, Target
from arramon_client.world import TURN, turn_between

STEPS = 3
"""Number of steps that a check takes, less than any reasonable step limit."""


@check("steps.numbered", runs=1)
def numbered(target: Target) -> None:
    """Observations number the steps from 0, start in the navigation phase of turn 1, and count down the steps left."""
    run = target.create()
    with target.play(run) as stream:
        _, _, seen = stream.begin()
        for step in range(min(STEPS, run.limits.steps_per_phase - 1) + 1):
            expect_equal("the observation's step", seen.step, step)
            expect_equal("the observation's phase_step", seen.phase_step, step)
            expect_equal("the observation's steps_left", seen.steps_left, run.limits.steps_per_phase - step)
            expect_equal("the observation's turn", seen.turn, 1)
            expect_equal("the observation's phase", seen.phase, types_pb2.PHASE_NAVIGATION)
            expect(seen.instruction, "the observation has no instruction, expected a text")
            if seen.steps_left > 1:
                stream.act(seen, LEFT)
                seen = stream.observation()


@check("steps.repeat", runs=1)
def repeat(target: Target) -> None:
    """A step repeated with the same action is answered again, but applied only once."""
    with target.play(target.create(sensors=target.pose_sensors())) as stream:
        _, _, start = stream.begin()
        stream.act(start, LEFT)
        first = stream.observation()
        stream.act(start, LEFT)
        again = stream.observation()
        _expect_repeated(first, again)


@check("steps.repeat_in_batch", runs=1)
def repeat_in_batch(target: Target) -> None:
    """A step that is twice in one message is answered twice, but applied only once."""
    with target.play(target.create(sensors=target.pose_sensors())) as stream:
        _, _, start = stream.begin()
        act = pb.Act(episode_id=start.episode_id, step=start.step, action=LEFT)
        stream.send(act, act)
        first, again = stream.observation(), stream.observation()
        _expect_repeated(first, again)


@check("steps.behind", runs=1)
def behind(target: Target) -> None:
    """A step repeated with another action is a problem, STEP_BEHIND; the first action remains valid."""
    with target.play(target.create(sensors=target.pose_sensors())) as stream:
        _, _, start = stream.begin()
        stream.act(start, LEFT)
        first = stream.observation()
        stream.act(start, RIGHT)
        stream.problem(pb.Problem.CODE_STEP_BEHIND, start.episode_id)
        stream.act(start, LEFT)  # A server may or may not send an observation with the problem; this act gets one.
        again = stream.observation()
        expect(
            without_clocks(first) == without_clocks(again),
            "after STEP_BEHIND the observation changed, expected the first to stand",
        )


@check("steps.ahead", runs=1)
def ahead(target: Target) -> None:
    """A step ahead of the expected one is a problem, STEP_AHEAD, and is not applied; the stream stays open."""
    with target.play(target.create()) as stream:
        _, _, start = stream.begin()
        stream.send(pb.Act(episode_id=start.episode_id, step=start.step + 1, action=LEFT))
        stream.problem(pb.Problem.CODE_STEP_AHEAD, start.episode_id)
        _goes_on(stream, start)


@check("steps.bad_action", runs=1)
def bad_action(target: Target) -> None:
    """An action that is missing or out of range is a problem, BAD_ACTION, and is not applied; the stream stays open."""
    with target.play(target.create()) as stream:
        _, _, start = stream.begin()
        place = {"episode_id": start.episode_id, "step": start.step}
        for act in (pb.Act(**place), pb.Act(**place, action=4), pb.Act(**place, action=-1)):  # type: ignore[arg-type]
            stream.send(act)
            stream.problem(pb.Problem.CODE_BAD_ACTION, start.episode_id)
        _goes_on(stream, start)


@check("steps.not_yours", runs=1)
def not_yours(target: Target) -> None:
    """An act for an episode that the stream does not have is a problem, NOT_YOUR_EPISODE; the stream stays open."""
    with target.play(target.create()) as stream:
        _, _, start = stream.begin()
        stream.send(pb.Act(episode_id="no such episode", step=0, action=LEFT))
        stream.problem(pb.Problem.CODE_NOT_YOUR_EPISODE, "no such episode")
        _goes_on(stream, start)


@check("steps.batch", runs=1)
def batch(target: Target) -> None:
    """Acts for several episodes in one message are all answered, each with its own episode's next observation."""
    with target.play(target.create(episodes=2), 2) as stream:
        stream.next("opened")
        starts = [stream.observation(), stream.observation()]
        stream.send(*(pb.Act(episode_id=seen.episode_id, step=seen.step, action=LEFT) for seen in starts))
        answers = [stream.observation(), stream.observation()]
        found = sorted((seen.episode_id, seen.step) for seen in answers)
        expect_equal("the list of answers", found, sorted((seen.episode_id, 1) for seen in starts))


@check("steps.forfeit", runs=1)
def forfeited(target: Target) -> None:
    """A forfeit ends the episode with CAUSE_FORFEITED, regardless of its step number."""
    with target.play(target.create()) as stream:
        _, _, start = stream.begin()
        act = forfeit(start.episode_id)
        act.step = 99
        stream.send(act)
        ended = stream.next("episode_ended")
        expect_equal("the episode that ended", ended.episode_id, start.episode_id)
        name = types_pb2.Cause.Name(ended.cause)
        expect(ended.cause == types_pb2.CAUSE_FORFEITED, f"the cause is {name}, expected CAUSE_FORFEITED")
        expect_equal("episodes_ended", ended.episodes_ended, 1)


@check("steps.turn", runs=1)
def turn(target: Target) -> None:
    """LEFT turns the agent in place by 30 degrees anticlockwise, seen from above, and RIGHT turns it back."""
    target.need_sensor("pose")
    with target.play(target.create(sensors=["pose"])) as stream:
        _, _, start = stream.begin()
        stream.act(start, LEFT)
        left = stream.observation()
        stream.act(left, RIGHT)
        back = stream.observation()
        for seen, expected in ((left, (start.pose.heading - TURN) % 360.0), (back, start.pose.heading)):
            off = abs(turn_between(expected, seen.pose.heading))
            expect(off < 1e-3, f"the heading is {seen.pose.heading:g} degrees, expected {expected:g}")
            expect(0.0 <= seen.pose.heading < 360.0, f"the heading is {seen.pose.heading:g}, expected 0 to below 360")
            place = (seen.pose.x, seen.pose.z)
            expect_equal("the place after a turn", place, (start.pose.x, start.pose.z))


@check("steps.forward", runs=1)
def forward(target: Target) -> None:
    """FORWARD in the city moves the agent by one unit along its heading, or not at all if blocked."""
    target.need_sensor("pose")
    with target.play(target.create(sensors=["pose"])) as stream:
        _, _, start = stream.begin()
        stream.act(start, FORWARD)
        seen = stream.observation()
        heading = math.radians(start.pose.heading)
        moved = (seen.pose.x - start.pose.x, seen.pose.z - start.pose.z)
        ways = ((math.sin(heading), math.cos(heading)), (0.0, 0.0))
        is_right = any(math.dist(moved, way) < 1e-3 for way in ways)
        expect(is_right, f"FORWARD moved the agent by {moved}, expected {ways[0]}, or {ways[1]} if blocked")
        expect_equal("the heading after FORWARD", seen.pose.heading, start.pose.heading)


def _goes_on(stream: RawStream, start: pb.Observation) -> None:
    """Check that an episode is still at its first step, and that its stream is open."""
    stream.act(start, LEFT)
    expect_equal("the step after the problem and a right action", stream.observation().step, start.step + 1)


def _expect_repeated(first: pb.Observation, again: pb.Observation) -> None:
    """Expect the answer to a repeated step 0 to be the same observation as before."""
    expect_equal("the step after the repeated action", again.step, 1)
    expect(
        without_clocks(first) == without_clocks(again),
        "the repeated step was answered with another observation than before",
    )


CHECKS = (
    numbered, repeat, repeat_in_batch, behind, ahead, bad_action, not_yours, batch, forfeited, turn, forward,
)  # fmt: skip
