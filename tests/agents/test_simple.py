"""Agents that ignore their sensors: random walk and stop."""

from collections import Counter
from itertools import pairwise

import pytest

from arramon_agents import random_walk, stop
from arramon_client import Action, Episode, Observation, load_agent


def observation(episode_id: str, step: int) -> Observation:
    return Observation(episode_id, 1, "navigation", step, "go", step, 150 - step)


def test_random_walk_is_the_same_in_every_order_and_process() -> None:
    agent = random_walk.Agent()
    agent.begin(Episode("a", "en", "val_seen"))
    together = agent.act([observation("a", 0), observation("b", 0), observation("a", 1)])
    alone = [random_walk.Agent().act([o])[0] for o in (observation("a", 0), observation("b", 0), observation("a", 1))]
    assert together == alone
    # Fixed for ever: a recorded run must be resumable by a later release.
    assert [int(agent.draw("8900", step)) for step in range(12)] == [2, 0, 1, 2, 3, 2, 0, 1, 3, 2, 0, 3]


def test_random_walk_draws_uniformly_and_independently() -> None:
    agent = random_walk.Agent()
    drawn = [agent.draw(f"e{i}", step) for i in range(40) for step in range(1, 251)]
    counts = Counter(drawn)
    pairs = Counter(pairwise(drawn))
    assert set(counts) == set(Action)
    assert all(2500 - 200 < count < 2500 + 200 for count in counts.values())  # 4.6 standard deviations
    assert len(pairs) == 16
    assert all(625 - 115 < count < 625 + 115 for count in pairs.values())


def test_different_seeds_give_different_walks() -> None:
    one, other = random_walk.Agent(seed=0), random_walk.Agent(seed=1)
    assert [one.draw("e", step) for step in range(30)] != [other.draw("e", step) for step in range(30)]


def test_stop_always_interacts() -> None:
    agent = stop.Agent()
    agent.begin(Episode("a", "en", "val_seen"))
    assert agent.act([observation("a", 0), observation("b", 7)]) == [Action.INTERACT, Action.INTERACT]
    assert agent.act([]) == []


@pytest.mark.parametrize(("spec", "sensors"), [
    ("agents.random_walk", ("rgb", "depth")), ("agents.stop", ("rgb", "depth")),
    ("agents.shortest_path", ("pose", "oracle")),
])  # fmt: skip
def test_each_agent_is_loaded_by_its_module_name(spec: str, sensors: tuple[str, ...]) -> None:
    agent = load_agent(spec)
    assert getattr(agent, "sensors") == sensors  # noqa: B009 - optional in the contract
    assert getattr(agent, "name") == spec.removeprefix("agents.")  # noqa: B009 - optional in the contract
