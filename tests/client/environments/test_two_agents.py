"""The PettingZoo environments, by PettingZoo's own tests, and what each agent sees."""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
import pytest

from arramon_client.environments import BadArgument
from arramon_client.environments.two_agents import env, parallel_env, raw_env
from tests import tiny

EXPECTED = (
    "Observation is not a NumPy array",
    "Observation space for each agent probably should be gymnasium.spaces.box",
    "Action space for each agent probably should be gymnasium.spaces.box",
    "We recommend agents to be named in the format",
)
"""Advice of PettingZoo's tests against dictionaries and telling names; anything else is an error."""


@pytest.fixture
def arguments(data: Path) -> Iterator[dict[str, Any]]:
    with warnings.catch_warnings():
        for message in EXPECTED:
            warnings.filterwarnings("ignore", message)
        yield {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 5}


@pytest.mark.parametrize("length", [0, 4])
@pytest.mark.parametrize("language", ["en", "hi"])
def test_pettingzoos_own_tests_pass(arguments: dict[str, Any], length: int, language: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # PettingZoo's tests import environments in a way that it warns of itself.
        from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test
    arguments |= {"message_length": length, "lang": language}
    api_test(raw_env(**arguments), num_cycles=60)
    api_test(env(**arguments), num_cycles=60)
    parallel_api_test(parallel_env(**arguments), num_cycles=60)
    seed_test(lambda: env(**arguments), num_cycles=30)
    parallel_seed_test(lambda: parallel_env(**arguments), num_cycles=30)
    render_test(lambda render_mode: env(render_mode=render_mode, **arguments))


def test_they_are_registered(arguments: dict[str, Any]) -> None:
    for kind in ("aec", "parallel"):
        made = pettingzoo.make(kind, "arramon/ArraMon-v0", **arguments)
        assert made.possible_agents == ["navigator", "assembler"]


def test_spaces_are_the_same_objects(arguments: dict[str, Any]) -> None:
    for made in (raw_env(**arguments), parallel_env(**arguments)):
        for agent in made.possible_agents:
            assert made.observation_space(agent) is made.observation_space(agent)
            assert made.action_space(agent) is made.action_space(agent)
        first, second = made.possible_agents
        assert made.action_space(first) is not made.action_space(second)  # Seeded apart.


def test_each_has_its_own_phases_instructions_and_rewards(arguments: dict[str, Any]) -> None:
    made = raw_env(**arguments | {"steps_per_phase": 8})
    made.reset(options={"episode": "1"})
    acted, totals = [], {"navigator": 0.0, "assembler": 0.0}
    blank = made.observe("assembler")
    assert (blank["instruction"], blank["active"], blank["rgb"].max(), blank["phase"]) == ("", 0, 0, 1)
    for action in tiny.ACTIONS:
        agent = made.agent_selection
        acted.append(agent[0])
        values = made.observe(agent)
        expected = {"navigator": "Go on to the striped red mug.", "assembler": "Put it two steps ahead."}[agent]
        assert (values["instruction"], values["active"]) == (expected, 1)
        other = made.observe("assembler" if agent == "navigator" else "navigator")
        assert other["active"] == 0
        made.step(action)
        for name, reward in made.rewards.items():
            totals[name] += reward
    assert "".join(acted) == "nnnaannnnnnaa"
    assert totals == {"navigator": 2.0, "assembler": 2.0}
    assert made.terminations == {"navigator": True, "assembler": True}
    assert made.infos["navigator"]["scores"] == made.infos["assembler"]["scores"]


def test_a_message_reaches_the_other(arguments: dict[str, Any]) -> None:
    made = raw_env(**arguments, message_length=3)
    made.reset(options={"episode": "1"})
    for action, symbols in ((0, [1, 2, 3]), (0, [4, 5, 6]), (3, [7, 8, 31])):
        made.step({"action": action, "message": np.array(symbols)})
    assert made.agent_selection == "assembler"
    assert made.observe("assembler")["message"].tolist() == [7, 8, 31]
    assert made.observe("navigator")["message"].tolist() == [0, 0, 0]
    for wrong in (0, {"action": 0}, {"action": 0, "message": [1, 2]}, {"action": 0, "message": [1, 2, 32]}):
        with pytest.raises(gymnasium.error.InvalidAction, match="expected"):
            made.step(wrong)


def test_bad_input(arguments: dict[str, Any]) -> None:
    with pytest.raises(BadArgument, match="message_length is -1, expected a number from 0"):
        raw_env(**arguments, message_length=-1)
    with pytest.raises(BadArgument, match="phases cannot be given"):
        parallel_env(**arguments, phases=("assembly",))
    made = parallel_env(**arguments | {"steps_per_phase": 1})
    with pytest.raises(gymnasium.error.ResetNeeded):
        made.step({"navigator": 0, "assembler": 0})
    made.reset()
    for _ in range(4):
        made.step({"navigator": 1, "assembler": 1})
    assert made.agents == []
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\)"):
        made.step({})
