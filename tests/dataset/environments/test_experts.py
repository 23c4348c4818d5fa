"""Experts lead to success from any state that a random agent reaches."""

import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from arramon_agents.shortest_path import Agent as ShortestPath
from arramon_client.agent import Episode, Observation
from arramon_dataset.environments import experts
from arramon_dataset.environments.player import LocalPlayer
from arramon_server.sim.rules import Phase
from arramon_server.sim.view import visible_pose
from tests import tiny
from tests.dataset.environments.players import player

STRAYS = 12
"""Actions that stray before the expert is followed."""


@pytest.mark.parametrize("expert", ["reference", "shortest"])
def test_from_the_start_it_succeeds(data: Path, expert: str) -> None:
    made = player(data, expert=expert)
    made.begin("1", 0)
    taken = follow(made)
    assert made.session.scores().turns[0]["PTC@CTC-0"] == 1.0
    assert made.session.scores().turns[1]["PTC@CTC-0"] == 1.0
    if expert == "reference":
        assert taken == list(tiny.ACTIONS)


def test_on_the_path_the_reference_is_the_ground_truth(data: Path) -> None:
    made = player(data, "sample", expert="reference")
    for episode_id in made.split.episode_ids or ():
        made.begin(episode_id, 0)
        follow(made)
        scores = made.session.scores()
        for turn in scores.turns:
            assert turn["nDTW"] == pytest.approx(1.0, abs=1e-4), episode_id  # The file's path is rounded.
            assert (turn["CTC-0"], turn["PTC"]) == (1.0, 1.0), episode_id


def strayed(made: LocalPlayer, phase: str, seeds: range) -> Iterator[int]:
    """Brings the player into states that random actions lead to in a phase of turn 1 or 2, again and again."""
    for seed in seeds:
        chance = random.Random(seed)
        made.begin(chance.choice(made.split.episode_ids or ()), 0)
        # A part of the ground truth first, so that states are near any part of the path, and in both turns.
        for _ in range(chance.randrange(25)):
            if not made.session.state.finished:
                made.step(made.expert_action())
        while not made.session.state.finished and made.session.state.phase.value != phase:
            made.step(made.expert_action())
        for _ in range(STRAYS):
            if not made.session.state.finished and made.session.state.phase.value == phase:
                made.step(chance.choice((0, 0, 1, 2)))
        if not made.session.state.finished:
            yield seed


@pytest.mark.parametrize("expert", ["reference", "shortest"])
@pytest.mark.parametrize("phase", ["navigation", "assembly"])
@pytest.mark.parametrize(
    "seeds", [pytest.param(range(40), id="some"), pytest.param(range(40, 90), id="more", marks=pytest.mark.slow)]
)
def test_from_states_off_the_path_it_succeeds_and_does_not_oscillate(
    data: Path, expert: str, phase: str, seeds: range
) -> None:
    made = player(data, "sample", expert=expert, steps_per_phase=1000)
    for seed in strayed(made, phase, seeds):
        states: set[Any] = set()
        turn = made.session.state.turn
        while not made.session.state.finished and made.session.state.turn == turn:
            state = made.session.state
            pose = visible_pose(state)
            here = state.phase, round(pose.x, 3), round(pose.z, 3), round(pose.heading)
            assert here not in states, f"seed {seed}: it comes back to {here}"
            states.add(here)
            made.step(made.expert_action())
        scores = made.session.scores().turns[turn - 1]
        assert (scores["CTC-0"], scores["CTC-3"], scores["PTC"]) == (1.0, 1.0, 1.0), f"seed {seed}"


def test_asking_twice_gives_the_same(data: Path) -> None:
    for expert in ("reference", "shortest"):
        made = player(data, expert=expert)
        made.begin("1", 0)
        while not made.session.state.finished:
            assert made.expert_action() == made.expert_action()
            made.step(made.expert_action())


def test_an_agent_that_takes_every_second_advice_gets_there(data: Path) -> None:
    """What the agent does of its own accord is not mistaken for a way that is blocked."""
    made = player(data, "sample", expert="shortest", steps_per_phase=1000)
    chance = random.Random(3)
    made.begin((made.split.episode_ids or ())[0], 0)
    while made.session.state.phase is Phase.NAVIGATION:
        advised = made.expert_action()
        made.step(advised if chance.random() < 0.6 or advised == 3 else chance.choice((0, 1, 2)))
    assert made.session.scores().turns[0]["CTC-0"] == 1.0


def test_off_the_path_of_turn_2_the_reference_plans_once_and_leads_to_the_target(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent = Counting()
    monkeypatch.setattr(experts, "_shortest_path_agent", lambda thread: agent)
    made = player(data, "sample", expert="reference", steps_per_phase=400)
    chance = random.Random(5)
    led = 0
    for episode_id in (made.split.episode_ids or ())[:6]:
        agent.begun = 0
        made.begin(episode_id, 0)
        while made.session.state.turn == 1:  # It turns on the spot until the limit, in the city and in the room.
            made.step(1)
        for _ in range(60):
            made.expert_action()
            made.step(chance.choice((0, 0, 1, 2)))
        assert agent.begun <= 1
        led += agent.begun
        follow(made)
        scores = made.session.scores().turns[1]
        assert (scores["CTC-0"], scores["CTC-3"], scores["PTC"]) == (1.0, 1.0, 1.0), episode_id
    assert led


class Counting:
    """The agent `shortest_path`, which counts the episodes that it begins: its plans."""

    def __init__(self) -> None:
        self._agent = ShortestPath()
        self.begun = 0

    def begin(self, episode: Episode) -> None:
        self.begun += 1
        self._agent.begin(episode)

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        return self._agent.act(observations)


def follow(made: LocalPlayer) -> list[int]:
    taken = []
    while not made.session.state.finished:
        taken.append(made.expert_action())
        made.step(taken[-1])
    return taken


def test_two_players_of_one_episode_do_not_confuse_their_experts(data: Path) -> None:
    """Each is advised as if it were alone, though one agent plans for all of them in a thread."""
    seeds = (1, 2)

    def played(order: Sequence[int]) -> list[list[int]]:
        made = {seed: player(data, "sample", expert="shortest") for seed in seeds}
        chances = {seed: random.Random(seed) for seed in seeds}
        advised: dict[int, list[int]] = {seed: [] for seed in seeds}
        for each in made.values():
            each.begin((each.split.episode_ids or ())[0], 0)
        for seed in order:
            advice = made[seed].expert_action()
            advised[seed].append(advice)
            made[seed].step(advice if chances[seed].random() < 0.7 else chances[seed].choice((0, 1, 2)))
        return [advised[seed] for seed in seeds]

    assert played(seeds * 25) == played(sorted(seeds * 25))
