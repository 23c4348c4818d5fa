"""Faults in claims of episodes, in resuming, and in limits."""

from collections.abc import Iterable

from arramon.v1 import evaluation_pb2 as pb
from tests.conformance.breakers.faults import again, answers, clears, drops, events, opens, requests, sets, twice
from tests.conformance.forwarder import Fault, Stream


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


def no_past(event: pb.Event, _: Stream) -> Iterable[pb.Event]:
    return () if event.WhichOneof("event") == "observation" and event.observation.HasField("taken") else (event,)


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
