"""Several streams of one run that is played step by step: an episode is on the stream that was assigned it last."""

from dataclasses import replace
from typing import Any

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import EpisodeLostError
from arramon_client.runs.live import LivePlayer, LiveRun
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.waiting import wait_for
from tests.client.fake import World


class Stream:
    """Stands in for a stream, and records what is sent."""

    def __init__(self) -> None:
        self.sent: list[pb.Act] = []
        self.cancelled = 0

    def send(self, acts: list[pb.Act]) -> None:
        self.sent += acts

    def cancel(self) -> None:
        self.cancelled += 1


@pytest.fixture
def live(run: pb.Run) -> LiveRun:
    return LiveRun(run, replays=True, notify=lambda _: None)


def player_of(live: LiveRun, run: pb.Run) -> Any:
    player: Any = LivePlayer(live, run, lambda _: None, replays=True)
    player.stream = Stream()
    return player


def start(player: Any, world: World, episode_id: str, *, history: bool = False) -> None:
    player.start_stream(history=history)
    for event in world.started(episode_id, history=history):
        player.take(event)


def next_episode(live: LiveRun) -> LiveEpisode:
    episode = wait_for(live.next_episode())
    assert episode is not None
    return episode


def test_an_episode_is_lost_on_the_stream_that_had_it_before(live: LiveRun, run: pb.Run, world: World) -> None:
    first, second = player_of(live, run), player_of(live, run)
    world.actions = {"e1": []}
    start(first, world, "e1")
    lost = next_episode(live)
    assert wait_for(lost.look()).step == 0
    world.actions["e1"] = [1]
    start(second, world, "e1", history=True)
    kept = next_episode(live)
    assert (lost.lost, kept.lost, first.must_reopen, first.stream.cancelled) == (True, False, True, 1)
    with pytest.raises(EpisodeLostError):
        wait_for(lost.look())
    assert wait_for(kept.look()).taken == 1


def test_an_act_waits_for_its_episode_on_a_new_stream(live: LiveRun, run: pb.Run, world: World) -> None:
    """The server refuses acts for episodes that it has not opened yet on the stream."""
    player = player_of(live, run)
    world.actions = {"e1": []}
    start(player, world, "e1")
    episode = next_episode(live)
    wait_for(episode.look())
    player.start_stream(history=False)
    acting = episode.act(0, 1)
    next(acting)
    assert (player.stream.sent, episode.recorded) == ([], (1,))
    for event in world.started("e1", history=False):
        player.take(event)
    assert [(act.step, act.action) for act in player.take_resends()] == [(0, 1)]
    acting.close()


def test_a_repeated_observation_brings_only_its_time_up_to_date(live: LiveRun, run: pb.Run, world: World) -> None:
    player = player_of(live, run)
    world.actions = {"e1": []}
    start(player, world, "e1")
    episode = next_episode(live)
    seen = wait_for(episode.look())
    player.start_stream(history=False)
    started, observed = world.started("e1", history=False)
    observed.observation.step_seconds_left = 7.0
    observed.observation.bank_seconds_left = 20.0
    for event in (started, observed):
        player.take(event)
    again = wait_for(episode.look())
    assert again == replace(seen, step_seconds_left=7.0, bank_seconds_left=20.0)
    assert again.rgb is seen.rgb
    left = again.seconds_left()
    assert left is not None
    assert 0 <= left <= 27.0
    assert replace(again, arrived=again.arrived - 30.0).seconds_left() == 0.0


def test_an_episode_is_given_up_after_its_history(live: LiveRun, run: pb.Run, world: World) -> None:
    player = player_of(live, run)
    world.actions = {"e1": [1, 2]}
    player.start_stream(history=True)
    events = world.started("e1", history=True)
    for event in events[:2]:
        player.take(event)
    episode = next_episode(live)
    giving_up = episode.give_up("enough")
    next(giving_up)
    player.start_stream(history=True)
    for event in events:
        player.take(event)
    assert player.stream.sent[-1].forfeit.reason == "enough"
    ended = pb.EpisodeEnded(episode_id="e1", cause=types_pb2.CAUSE_FORFEITED)
    player.take(pb.Event(episode_ended=ended))
    with pytest.raises(StopIteration):
        next(giving_up)
    assert episode.cause == "FORFEITED"
