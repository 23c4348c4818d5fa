"""Checks of resumption after a stream breaks: open episodes return, with the latest observation or the history."""

import itertools
import time

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.conformance.assertions import expect, expect_equal
from arramon_client.conformance.raw_stream import RawStream, without_clocks
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import LEFT, RIGHT, Target

ACTIONS = (LEFT, RIGHT, LEFT)
"""Actions taken before the stream breaks."""

PAUSE = 0.5
"""Seconds between two attempts to adopt an episode."""


@check("resume.latest", runs=1)
def latest(target: Target) -> None:
    """A new stream of the same player gets the open episode back at its current step, with the latest observation."""
    run = target.create(sensors=target.pose_sensors())
    seen = _play_and_break(target, run)
    with target.play(run, player="conformance") as stream:
        opened, started, back = stream.begin()
        expect_equal("the list of episodes that came back", list(opened.episode_ids), [seen[0].episode_id])
        expect_equal("the step at which the episode came back", started.step, len(ACTIONS))
        expect(
            without_clocks(back) == without_clocks(seen[-1]),
            "the episode came back with another observation than its latest",
        )


@check("resume.recorded", runs=1)
def recorded(target: Target) -> None:
    """Every answered step is recorded: the run counts all of them after the stream broke."""
    run = target.create()
    _play_and_break(target, run)
    expect_equal("the number of steps recorded", target.get(run).steps, len(ACTIONS))


@check("resume.history", runs=1)
def history(target: Target) -> None:
    """With `history`, an open episode is repeated from its first observation on, each with the action taken."""
    run = target.create(sensors=target.pose_sensors())
    seen = _play_and_break(target, run)
    with target.play(run, player="conformance", history=True) as stream:
        opened = stream.next("opened")
        expect_equal("the list of episodes that came back", list(opened.episode_ids), [seen[0].episode_id])
        _expect_history(stream, seen)


@check("resume.adopted", runs=1)
def adopted(target: Target) -> None:
    """With `adopt`, a new player takes over the episodes that another one left open, always with their history."""
    run = target.create(sensors=target.pose_sensors())
    left = _play_and_break(target, run)
    until = time.monotonic() + target.timeout
    # The server may notice the broken stream only after the next one begins: each attempt is a new player, and requests
    # one episode more than the last, as earlier attempts have left episodes open.
    for attempt in itertools.count(1):
        with target.play(run, attempt, player=f"conformance-heir-{attempt}", adopt=True) as stream:
            if left[0].episode_id in stream.next("opened").episode_ids:
                _expect_history(stream, left)
                return
        expect(time.monotonic() < until, f"the episode was not adopted in {attempt} attempts, expected it in `opened`")
        time.sleep(PAUSE)


def _play_and_break(target: Target, run: pb.Run) -> list[pb.Observation]:
    """Play some steps on a stream and break it; return the observations."""
    with target.play(run, player="conformance") as stream:
        _, _, start = stream.begin()
        seen = [start]
        for action in ACTIONS:
            stream.act(seen[-1], action)
            seen.append(stream.observation())
    return seen


def _expect_history(stream: RawStream, seen: list[pb.Observation]) -> None:
    """Check that an episode's next observations are the earlier ones, with the actions taken."""
    for number, (live, taken) in enumerate(zip(seen, (*ACTIONS, None), strict=True)):
        while (repeated := stream.observation()).episode_id != live.episode_id:
            pass
        what = f"observation {number} of the history"
        found = repeated.taken if repeated.HasField("taken") else None
        expect_equal(f"the action taken in {what}", found, taken)
        expect(
            without_clocks(repeated, "taken") == without_clocks(live),
            f"{what} is not the one that was seen when it was played",
        )


CHECKS = (latest, recorded, history, adopted)
