"""Trial episodes, which an agent plays in process."""

from collections.abc import Iterator, Sequence
from contextlib import closing

import numpy as np
import pytest

from arramon_client.agent import Action, Episode, Label, Observation
from arramon_dataset.trial import AGENT_LABELS, EarlyStop, play, play_or_stop_early
from arramon_server.episodes import episode as episodes
from arramon_server.sim.own_furniture import NO_FURNITURE
from arramon_server.sim.room import RoomCell, RoomPosition
from arramon_server.sim.section_world import EpisodeWorld, SectionWorld
from tests.dataset.instructions.town import ACTIONS, PATH, START, STREET, P, crossing


class Replaying:
    """Takes given actions, and keeps what it was shown."""

    def __init__(self, actions: Sequence[int]) -> None:
        self.actions = list(actions)
        self.seen: list[Observation] = []
        self.episode: Episode | None = None
        self.ended: list[str] = []

    def end(self, episode_id: str) -> None:
        self.ended.append(episode_id)

    def begin(self, episode: Episode) -> None:
        self.episode = episode

    def act(self, observations: Sequence[Observation]) -> list[int]:
        self.seen += observations
        return [self.actions.pop(0) if self.actions else Action.INTERACT for _ in observations]


@pytest.fixture(scope="module")
def place() -> Iterator[EpisodeWorld]:
    with closing(SectionWorld(crossing())) as section:
        yield section.in_episode(NO_FURNITURE, episode().layout)


def episode() -> episodes.Episode:
    cell = RoomPosition(2, 1, 1)
    first = episodes.Turn(PATH, ACTIONS, (RoomCell(2, 0),), (P,), STREET, cell)
    second = episodes.Turn((PATH[-1],), (P,), (RoomCell(2, 0),), (P,), STREET, RoomPosition(2, 2, 1))
    texts = tuple(episodes.Instructions(f"go {i}", f"put {i}") for i in (1, 2))
    return episodes.Episode("e", "test", START, (first, second), (), {"en": (texts[0], texts[1])})


def test_ground_truth_scores_one(place: EpisodeWorld) -> None:
    agent = Replaying([*ACTIONS, P, P, P])
    scores = play(agent, episode(), "en", place, size=64)
    for turn in scores.turns:
        assert [turn[name] for name in ("nDTW", "CTC-0", "CTC-3", "PTC")] == pytest.approx([1.0] * 4)


def test_trial_observations_follow_the_agent_contract(place: EpisodeWorld) -> None:
    agent = Replaying([*ACTIONS, P, P, P])
    play(agent, episode(), "en", place, size=64)
    assert agent.episode == Episode("e", "en", "trial", labels=AGENT_LABELS)
    assert agent.ended == ["e"]
    assert [o.instruction for o in agent.seen[-3:]] == ["put 1", "go 2", "put 2"]
    first = agent.seen[0]
    assert (first.step, first.phase, first.turn, first.steps_left) == (0, "navigation", 1, 150)
    assert first.pose is None
    assert first.rgb is None
    assert first.segmentation is not None
    assert first.depth is not None
    assert first.depth.dtype == np.float32
    assert first.segmentation.dtype == np.uint16
    labels = {AGENT_LABELS[number] for number in np.unique(first.segmentation).tolist()}
    assert {Label("road"), Label("phone_booth"), Label("building", look="brick")} <= labels


def test_agent_that_only_turns_is_stopped_at_the_step_limit(place: EpisodeWorld) -> None:
    agent = Replaying([Action.LEFT] * 600)
    scores = play(agent, episode(), "en", place, size=16)
    assert len(agent.seen) == 600
    assert [turn["PTC"] for turn in scores.turns] == [0.0, 0.0]


def test_a_trial_with_hope_is_played_to_its_end(place: EpisodeWorld) -> None:
    actions = [*ACTIONS, P, P, P]
    scores = play_or_stop_early(Replaying(actions), episode(), "en", place, EarlyStop(episode().turns, 0.2))
    assert scores == play(Replaying(actions), episode(), "en", place)


@pytest.mark.parametrize(
    ("actions", "most"),
    [
        ([*[Action.FORWARD] * 27, *[Action.FORWARD, Action.LEFT] * 50], 100),  # Past the crossing.
        ([*ACTIONS[:15], *[Action.LEFT] * 3, *[Action.FORWARD] * 7, P], 30),  # Another object, far from the target.
    ],
)
def test_a_trial_ends_when_there_is_no_hope(place: EpisodeWorld, actions: list[int], most: int) -> None:
    agent = Replaying([*actions, *[Action.FORWARD] * 150])
    assert play_or_stop_early(agent, episode(), "en", place, EarlyStop(episode().turns, 0.2)) is None
    assert len(agent.seen) < most
    assert agent.ended == ["e"]
    scores = play(Replaying([*actions, *[Action.FORWARD] * 150]), episode(), "en", place, size=16)
    assert scores.turns[0]["CTC-3"] == 0.0 or scores.turns[0]["nDTW"] <= 0.2
