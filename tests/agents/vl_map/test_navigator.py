"""Execution of decisions: looking, walking on the map, pick-up, and options that are not repeated."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import MappedLandmark
from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.perception.scan import Scan
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.vl_map.features import PolicyInput
from arramon_agents.vl_map.navigator import LOOK_BOTH_SIDES, MAX_MOVES, RESERVED_STEPS, MapNavigator
from arramon_agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS
from arramon_client.agent import Action, Label
from arramon_lang.meaning import Navigation, Thing

AHEAD = DISTANCES.index(6.5)
"""The waypoint 6.5 units ahead."""


class World(AgentBody):
    """A body on an open square, on which nothing but a mug lies."""

    def __init__(self, *mugs: tuple[float, float]) -> None:
        super().__init__(LABELS)
        number = next(number for number, label in enumerate(LABELS) if label.kind == "mug")
        self.landmarks._by_label[number] = [MappedLandmark(Label("mug"), *mug, 1.0) for mug in mugs]
        free = np.stack(np.meshgrid(np.arange(-15, 15, 0.2), np.arange(-15, 15, 0.2)), -1).reshape(-1, 2)
        self.ground.add(Scan(np.zeros((0, 2), np.float32), np.zeros(0, bool), free.astype(np.float32)))

    def apply(self, action: Action) -> None:
        self.record_action(action)
        self._move(same=False)


class Choices:
    """Chooses one option after the other, and the last one on."""

    def __init__(self, *options: int) -> None:
        self.options = list(options)
        self.asked = 0

    def __call__(self, sample: PolicyInput, beliefs: Sequence[LandmarkBelief]) -> npt.NDArray[np.float32]:
        values = np.zeros(OPTIONS, np.float32)
        values[self.options[min(self.asked, len(self.options) - 1)]] = 1.0
        self.asked += 1
        return values


def play(world: World, choices: Choices, steps: int, left: int = 150, *, looks: bool = True) -> list[Action]:
    navigator = MapNavigator(world, rows_of(Navigation((), Thing("mug"))), choices, 1, looks=looks)
    actions = []
    for step in range(steps):
        actions.append(navigator.act(left - step))
        world.apply(actions[-1])
    return actions


def test_it_looks_around_first_and_after_each_walk() -> None:
    actions = play(World(), Choices(AHEAD), 12 + MAX_MOVES + len(LOOK_BOTH_SIDES) + MAX_MOVES)
    forward = [Action.FORWARD] * MAX_MOVES
    assert actions == [Action.RIGHT] * 12 + forward + list(LOOK_BOTH_SIDES) + forward


def test_it_walks_without_looking_around() -> None:
    assert play(World(), Choices(AHEAD), 2 * MAX_MOVES, looks=False) == [Action.FORWARD] * 2 * MAX_MOVES


def test_it_saves_steps_when_few_are_left() -> None:
    actions = play(World(), Choices(AHEAD), 12 + 3 * MAX_MOVES, left=RESERVED_STEPS + 12)
    assert actions == [Action.RIGHT] * 12 + [Action.FORWARD] * (3 * MAX_MOVES)


def test_a_waypoint_aside() -> None:
    world = World()
    play(world, Choices(6 * len(DISTANCES) + DISTANCES.index(4.0)), 12 + 3 + MAX_MOVES)
    assert (world.x, world.z) == pytest.approx((3.0, 0.0), abs=0.6)


def test_it_goes_to_a_thing_and_picks_it_up() -> None:
    world = World((2.0, 4.0))
    actions = play(world, Choices(WAYPOINTS), 40)
    first = actions.index(Action.INTERACT)
    assert 3 <= actions[:first].count(Action.FORWARD) <= 5
    # The pick-up had no effect: it is not tried again.
    assert actions.count(Action.INTERACT) == 1


def test_what_leads_nowhere_is_passed_over() -> None:
    world = World()
    wall = np.stack([np.arange(-14.0, 14.0, 0.1), np.full(280, 0.9)], 1).astype(np.float32)
    world.ground.add(Scan(wall, np.ones(len(wall), bool), np.zeros((0, 2), np.float32)))
    choices = Choices(WAYPOINTS + 3)  # There is no such landmark.
    actions = play(world, choices, 40)
    assert choices.asked > 1
    assert Action.INTERACT not in actions
    assert math.isfinite(world.x)
    assert world.z < 0.9
