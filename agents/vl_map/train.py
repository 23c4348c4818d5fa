"""Training of `vl_map`: its policy and room network, validation by real rollouts, weights and model card."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.simulated.courses import training_episodes
from arramon_agents.simulated.rooms import tasks_of
from arramon_agents.training.card import command_with, page
from arramon_agents.training.rollouts import Plan, mean, play
from arramon_agents.vl_map.agent import SeeingAgent
from arramon_agents.vl_map.dagger import MapRecipe, MapTraining, Tell
from arramon_agents.vl_map.policy import Networks, Policy, write_policy
from arramon_agents.vl_map.room import Placement
from arramon_agents.vl_map.train_room import train_rooms
from arramon_agents.weights import SUFFIX

NAME = "vl_map"

IMAGE_SIZE = 224
"""Side length of the images in validation, in pixels."""

LIMITS = """\
- It is trained on generated episodes alone. On people's instructions it reaches less than half of it (docs/results.md).
- In training its eyes are simulated: the faults are drawn at the rates that were measured on frames of `train`, one
  thing at a time. Things that hide each other, or are cut off at a frame's edge, are not simulated.
- It knows the instruction only as the learned reader read it, mistakes included.
- It looks around at the start and after each walk of three moves, as long as there are steps to spare: it takes more
  actions than an expert.
- In the room it looks around and walks by the rules of `agents.seeing_follower`; the cell is found by its network,
  which knows nothing of ordinals there, and nothing of relations of a landmark itself."""


@dataclass(frozen=True)
class Validation:
    """The episodes to play for validation.

    Attributes:
        split: its name.
        episodes: number of its first episodes to play; 0 for no validation.
    """

    split: str = "val_seen"
    episodes: int = 16


def train_map(recipe: MapRecipe, validation: Validation, data: Path, output: Path, tell: Tell) -> Path:
    """Train, resuming from a saved state if there is one; return the path of the weights (the card is beside it).

    Raises:
        ArraMonError: if the data folder does not have what is needed.
        ValueError: if the output folder holds a state of another recipe or other data.
    """
    prepare_process()
    training = MapTraining(recipe, data, output, tell)
    training.run()
    network = training.network.eval()
    found = training_episodes(data, recipe.languages, recipe.episodes)
    tasks = [task for _, episodes in found for task in tasks_of(episodes, recipe.languages, load_reader())]
    placer, seconds = train_rooms(tasks, recipe.seed)
    networks = Networks(network, placer)
    about: dict[str, Any] = {
        "recipe": asdict(recipe) | {"languages": list(recipe.languages)},
        "data": training.told,
        "data_hash": training.data_hash,
        "updates": training.updates,
        "cpu_seconds": round(training.seconds + seconds),
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
        "room_parameters": sum(parameter.numel() for parameter in placer.parameters()),
        "rooms": len(tasks),
    }
    if validation.episodes:
        plan = Plan(data, validation.split, recipe.languages, validation.episodes, IMAGE_SIZE)
        scores = play(SeeingAgent(Policy(network), Placement(placer)), plan)
        about["validation"] = asdict(validation) | {name: mean(scores, name) for name in ("nDTW", "CTC-3", "PTC")}
        tell(f"{NAME}: validation: {json.dumps(about['validation'])}")
    weights = output / f"{NAME}{SUFFIX}"
    write_policy(weights, networks, about)
    weights.with_suffix(".md").write_text(card(about), encoding="utf-8")
    return weights


def card(about: Mapping[str, Any]) -> str:
    """Return the model card of a policy, in Markdown."""
    recipe = about["recipe"]
    rows = {
        "agent": "`agents.vl_map`. It chooses waypoints on the landmarks and the free ground that it remembers.",
        "model": f"`agents/vl_map/network.py`, {about['parameters']:,} parameters, and `room.py`, "
        f"{about['room_parameters']:,}; with them come the visual encoder `eyes` and the learned reader",
        "training data": f"{about['data']}, {about['rooms']} rooms; SHA-256 of `train` {about['data_hash'][:12]}",
        "command": f"`{command_with(NAME, recipe, asdict(MapRecipe()))}`",
        "seed": recipe["seed"],
        "updates": about["updates"],
        "CPU time": f"{about['cpu_seconds'] / 60:.0f} minutes, with the simulated walks",
        "validation": _validated(about.get("validation")),
    }
    return page(NAME, rows, LIMITS)


def _validated(found: Mapping[str, Any] | None) -> str:
    if not found:
        return "none"
    return (
        f"on the first {found['episodes']} episodes of `{found['split']}`, in each language by turns, after the last "
        f"update: nDTW {found['nDTW']:.3f}, CTC-3 {found['CTC-3']:.3f}, PTC {found['PTC']:.3f}"
    )
