"""Splits of made-up episodes that ask for different things."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from arramon_client.world import Action
from arramon_server.episodes.demands import TurnDemands, write_demands
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder, write_split
from arramon_server.sim.catalogue import ALL_TYPES
from tests import tiny

STEPS = ("ahead", "turn_at", "past", "to", "turn", "until", "face", "along", "between")
RELATIONS = ("behind", "near", "left_of", "right_of", "on_top_of", "in_front_of", "against", "between")


def written(data: Path, name: str, count: int, *, hidden: bool = False) -> Split:
    """A split in a data folder, with the file of its demands."""
    made = split(name, count, hidden=hidden)
    episodes, sections = made.episodes.values(), made.sections.values()
    on_disk = write_split(data, name, hidden=hidden, source="generated", episodes=episodes, sections=sections)
    write_demands(split_folder(data, name), on_disk.data_hash, made.demands)
    return read_split(split_folder(data, name))


def split(name: str, count: int, *, hidden: bool = False, seed: int = 0) -> Split:
    """A split in memory."""
    draw = np.random.default_rng(seed)
    episodes = {f"{number:04d}": _episode(f"{number:04d}", draw) for number in range(count)}
    demands = {name: (_demands(draw), _demands(draw)) for name in episodes}
    return Split(name, hidden, "generated", episodes, {"1": tiny.SECTION}, "0" * 64, demands=demands)


def _episode(name: str, draw: np.random.Generator) -> Episode:
    plain = tiny.episode(name)
    turns = []
    for turn in plain.turns:
        moves, corners = int(draw.integers(3, 40)), int(draw.integers(0, 5))
        path = tuple((0.0, float(place)) for place in range(moves + 1))
        actions = (*[Action.FORWARD, Action.LEFT, Action.LEFT] * corners, *[Action.FORWARD] * moves, Action.INTERACT)
        target = replace(turn.target, type=ALL_TYPES[int(draw.integers(len(ALL_TYPES)))])
        turns.append(replace(turn, path=path, actions=actions, street=(target, *turn.street[1:])))
    return replace(plain, turns=(turns[0], turns[1]))


def _demands(draw: np.random.Generator) -> TurnDemands:
    chances = 1.0 / np.arange(1, len(STEPS) + 1)
    steps = draw.choice(STEPS, int(draw.integers(2, 8)), p=chances / chances.sum())
    marks = draw.choice(("object", "building", "banner", "place"), int(draw.integers(0, 6)), p=(0.5, 0.3, 0.05, 0.15))
    near, placed = (draw.choice(RELATIONS, int(draw.integers(low, 3))) for low in (0, 1))
    return TurnDemands(*(tuple(map(str, names)) for names in (steps, marks, near, placed)))
