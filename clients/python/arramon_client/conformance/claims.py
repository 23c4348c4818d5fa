"""Checks of claims: only one stream at a time plays an episode."""

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.conformance.assertions import expect, expect_equal
from arramon_client.conformance.raw_stream import RawStream
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import LEFT, RIGHT, Target


@check("claims.opened", runs=1)
def opened(target: Target) -> None:
    """A stream starts with `opened`; each episode starts with its id, language and split, then an observation."""
    run = target.create()
    with target.play(run) as stream:
        first, started, seen = stream.begin()
        expect_equal("the run in `opened`", first.run.run_id, run.run_id)
        expect_equal("the list of episodes that a new player gets back", list(first.episode_ids), [])
        expect_equal("the episode observed first", seen.episode_id, started.episode_id)
        expect_equal("the episode's language", started.language, target.language)
        expect_equal("the episode's split", started.split, target.split.name)
        expect_equal("the steps taken in a new episode", started.step, 0)


@check("claims.apart", runs=1)
def apart(target: Target) -> None:
    """Two streams of one run never hold the same episode, and neither can play the other's."""
    run = target.create(episodes=2)
    with target.play(run, player="conformance-a") as one, target.play(run, player="conformance-b") as other:
        _, _, mine = one.begin()
        _, _, theirs = other.begin()
        expect(mine.episode_id != theirs.episode_id, f"two streams hold the episode {mine.episode_id!r} at once")
        other.act(mine, LEFT)
        other.problem(pb.Problem.CODE_NOT_YOUR_EPISODE, mine.episode_id)
        one.act(mine, RIGHT)
        expect_equal("the step after another stream's act and its own", one.observation().step, 1)


@check("claims.live", runs=1)
def live(target: Target) -> None:
    """A stream that adopts open episodes does not take those that another stream is playing."""
    run = target.create()
    with target.play(run, player="conformance-a") as one:
        _, _, start = one.begin()
        with target.play(run, player="conformance-b", adopt=True) as other:
            back = list(other.next("opened").episode_ids)
            expect_equal("the list of episodes that an adopting stream got back", back, [])
            one.act(start, LEFT)
            expect_equal("the step of the stream that was playing", one.observation().step, 1)


@check("claims.replaced", runs=1)
def replaced(target: Target) -> None:
    """A new stream of the same player takes the place of the old one, which can no longer play its episodes."""
    run = target.create()
    with target.play(run, player="conformance") as old:
        _, _, start = old.begin()
        with target.play(run, player="conformance") as new:
            first, _, seen = new.begin()
            expect_equal("the list of episodes that came back", list(first.episode_ids), [start.episode_id])
            old.act(start, LEFT)
            _expect_displaced(old, start)
            new.act(seen, RIGHT)
            expect_equal("the step of the new stream after its first act", new.observation().step, 1)


def _expect_displaced(old: RawStream, start: pb.Observation) -> None:
    """Check that a stream ends, or reports that the episode is no longer its own."""
    try:
        event = old.event()
    except grpc.RpcError:
        return
    if event is not None:
        kind = event.WhichOneof("event")
        expect(kind == "problem", f"the old stream played on, and was sent {kind}, expected its end or a problem")
        code = event.problem.code
        named = pb.Problem.Code.Name(code)
        is_right = code == pb.Problem.CODE_NOT_YOUR_EPISODE and event.problem.episode_id == start.episode_id
        expect(is_right, f"the old stream was sent the problem {named}, expected CODE_NOT_YOUR_EPISODE")


CHECKS = (opened, apart, live, replaced)
