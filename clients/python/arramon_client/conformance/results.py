"""Checks of a run's results: one cause per episode, the end, the report, the receipt, and determinism."""

import tempfile
from pathlib import Path

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.conformance.assertions import expect, expect_equal, expect_refusal
from arramon_client.conformance.raw_stream import RawStream, forfeit, without_clocks
from arramon_client.conformance.runs import check_time
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import FORWARD, INTERACT, LEFT, RIGHT, Target
from arramon_client.receipts import check_key, compare_actions, read_receipt, write_receipt

ACTIONS = (FORWARD, LEFT, FORWARD, RIGHT, FORWARD, INTERACT, RIGHT, FORWARD, LEFT, FORWARD, FORWARD, INTERACT)
"""Actions played to compare two runs; an episode that ends earlier is compared up to its end."""

OPEN_AT_ONCE = 16
"""Maximum number of open episodes of a check."""


@check("results.ended", runs=1)
def ended(target: Target) -> None:
    """Every episode ends once, with a cause; then the run ends, complete, and the server closes the stream."""
    run = target.create(episodes=2)
    target.check_bounded(run)
    ends: list[pb.EpisodeEnded] = []
    over: list[pb.Run] = []
    with target.play(run, min(OPEN_AT_ONCE, target.info.max_episodes_per_stream)) as stream:
        for event in stream.rest():
            kind = event.WhichOneof("event")
            expect(not over, f"after `run_ended` the stream sent {kind}, expected its end")
            if kind == "observation" and event.observation.step == 0:
                stream.act(event.observation, LEFT)
            elif kind == "observation":
                stream.send(forfeit(event.observation.episode_id))
            elif kind == "episode_ended":
                ends.append(event.episode_ended)
            elif kind == "run_ended":
                over.append(event.run_ended.run)
    expect(over, "the stream ended without `run_ended`, expected it after the last episode")
    last = over[0]
    expect_equal(
        "the number of episodes that ended, each counted once,", len({end.episode_id for end in ends}), run.episodes
    )
    expect_equal("the list of episodes_ended", [end.episodes_ended for end in ends], list(range(1, run.episodes + 1)))
    expect(all(end.cause == types_pb2.CAUSE_FORFEITED for end in ends), "a forfeited episode ended with another cause")
    expect_equal("the state of the run", pb.RunState.Name(last.state), "RUN_STATE_COMPLETE")
    expect_equal("the run's causes", dict(last.causes), {"FORFEITED": run.episodes})
    expect_equal("the run's number of steps", last.steps, run.episodes)
    check_time("ended_at", last.ended_at)
    expect_equal("the run as GetRun returns it", target.get(run), last)


@check("results.one_cause", runs=1)
def one_cause(target: Target) -> None:
    """An episode that has ended keeps its cause, and is not played on, whatever is sent for it."""
    run = target.create(episodes=2)
    with target.play(run) as stream:
        _, _, start = stream.begin()
        stream.send(forfeit(start.episode_id))
        first = stream.next("episode_ended")
        following = stream.observation()
        expect(following.episode_id != start.episode_id, "an episode that has ended was offered again")
        stream.act(start, LEFT)
        stream.send(forfeit(start.episode_id))
        stream.act(following, LEFT)  # Answered after the acts for the ended episode.
        while (event := stream.event()) is not None and event.WhichOneof("event") != "observation":
            kind = event.WhichOneof("event")
            is_right = kind == "problem" or (kind == "episode_ended" and event.episode_ended == first)
            expect(
                is_right,
                f"after its end the episode was answered by {kind}, expected a problem, the same end again, or nothing",
            )
    found = target.get(run)
    expect_equal("episodes_ended", found.episodes_ended, 1)
    expect_equal("the run's causes", dict(found.causes), {"FORFEITED": 1})


@check("results.cancelled", runs=1)
def cancelled(target: Target) -> None:
    """CancelRun forfeits unfinished episodes, which stay in the denominator; a second call: FAILED_PRECONDITION."""
    run = target.create()
    over = target.cancel(run)
    expect_equal("the state of the run", pb.RunState.Name(over.state), "RUN_STATE_CANCELLED")
    expect_equal("the number of episodes", over.episodes, run.episodes)
    expect_equal("episodes_ended", over.episodes_ended, run.episodes)
    expect_equal("the run's causes", dict(over.causes), {"FORFEITED": run.episodes})
    check_time("ended_at", over.ended_at)
    code = grpc.StatusCode.FAILED_PRECONDITION
    expect_refusal("CancelRun of a run that is over", lambda: target.cancel(run), code)


@check("results.over", runs=1)
def over(target: Target) -> None:
    """A stream opened on a run that has ended gets `run_ended`, and is closed."""
    run = target.create()
    target.cancel(run)
    with target.play(run) as stream:
        found = stream.next("run_ended", ("opened",)).run
        expect_equal("the state of the run", pb.RunState.Name(found.state), "RUN_STATE_CANCELLED")
        expect(stream.event() is None, "after `run_ended` the stream went on, expected its end")


@check("results.report", runs=1)
def report(target: Target) -> None:
    """The report has scores per turn and in total, within their intervals, and on open splits for every episode."""
    run, played = _played(target)
    found = target.call("GetReport", pb.GetReportRequest(run_id=run.run_id))
    expect_equal("the report's run", found.run, target.get(run))
    expect(found.signature.strip(), "the report's signature is empty, expected one line")
    expect("\n" not in found.signature, "the report's signature has several lines, expected one")
    expect_equal("the list of rows", [row.name for row in found.rows], ["turn 1", "turn 2", "total"])
    for row in found.rows:
        expect(row.scores, f"the row {row.name!r} has no scores, expected some")
        for score in row.scores:
            said = f"{score.metric} of {row.name} is {score.mean:g}, in {score.low:g} to {score.high:g}"
            expect(score.low <= score.mean <= score.high, f"{said}, expected it within its interval")
    if target.split.hidden:
        expect_equal("the number of single episodes of a hidden split", len(found.episodes), 0)
        return
    expect_equal("the number of episodes in the report", len(found.episodes), run.episodes)
    steps = {episode.episode_id: episode.steps for episode in found.episodes}
    for episode_id, actions in played.items():
        expect_equal(f"the steps of episode {episode_id!r}", steps.get(episode_id), len(actions))
    causes = {types_pb2.Cause.Name(episode.cause) for episode in found.episodes}
    expect_equal("the set of causes", causes, {"CAUSE_FORFEITED"})


@check("results.receipt", runs=1)
def receipt(target: Target) -> None:
    """The receipt is signed with the host's key, and its hash chain covers the actions that were sent."""
    run, played = _played(target)
    found = target.call("GetReceipt", pb.GetReceiptRequest(run_id=run.run_id))
    with tempfile.TemporaryDirectory(prefix="arramon-conformance-") as folder:
        read = read_receipt(write_receipt(found, run.run_id, Path(folder)))
    check_key(read, target.info.public_key, "the server's key")
    expect_equal("the receipt's run", read.run["run_id"], run.run_id)
    expect_equal("the receipt's data hash", read.content["data_hash"], run.data_hash)
    expect_equal("the receipt's causes", read.content["causes"], {"FORFEITED": run.episodes})
    compared = compare_actions(read, played)
    expect(not compared.differences, "; ".join(compared.differences))
    expect_equal("the number of episodes checked", compared.same, len(played))
    again = target.call("GetReceipt", pb.GetReceiptRequest(run_id=run.run_id))
    expect(again == found, "the receipt changed from one call to the next, expected the same bytes")


@check("results.deterministic", runs=2)
def deterministic(target: Target) -> None:
    """The same actions give the same observations and the same scores."""
    sensors = [name for name in ("rgb", "depth", "pose") if name in target.split.sensors]
    seen: list[dict[int, pb.Observation]] = []
    rows = []
    for _ in range(2):
        run = target.create(sensors=sensors)
        with target.play(run, image_size=target.smallest()) as stream:
            seen.append(_observations(stream))
        target.cancel(run)
        rows.append(list(target.call("GetReport", pb.GetReportRequest(run_id=run.run_id)).rows))
    first, second = seen
    expect_equal("the list of steps played again", list(second), list(first))
    differing = [step for step in first if first[step] != second[step]]
    expect(not differing, f"the same actions gave another observation from step {differing[:1]} on, expected the same")
    expect(rows[0] == rows[1], "the same actions gave other scores, expected the same")


def _observations(stream: RawStream) -> dict[int, pb.Observation]:
    """Play the first episode; return its observations by step."""
    _, _, start = stream.begin()
    seen = {0: without_clocks(start)}
    for step, action in enumerate(ACTIONS):
        stream.send(pb.Act(episode_id=start.episode_id, step=step, action=action))
        while (event := stream.event()) is not None and event.WhichOneof("event") == "phase_ended":
            pass
        if event is None or event.WhichOneof("event") != "observation":
            break
        seen[step + 1] = without_clocks(event.observation)
    return seen


def _played(target: Target) -> tuple[pb.Run, dict[str, list[int]]]:
    """Play a few steps of a run and cancel it; return it, and the actions sent, by episode."""
    run = target.create()
    with target.play(run) as stream:
        _, _, seen = stream.begin()
        for action in (LEFT, RIGHT):
            stream.act(seen, action)
            seen = stream.observation()
    target.cancel(run)
    return run, {seen.episode_id: [int(LEFT), int(RIGHT)]}


CHECKS = (ended, one_cause, cancelled, over, report, receipt, deterministic)
