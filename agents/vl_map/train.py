"""Training of `vl_map`: policy and placement network, validation by rollouts, weights and model card."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch

from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.simulated.courses import training_episodes
from arramon_agents.simulated.room_examples import RoomExample, room_examples_of
from arramon_agents.training.card import model_card, training_command
from arramon_agents.training.recipe import as_json
from arramon_agents.training.rollouts import RolloutPlan, check_validation, mean, play
from arramon_agents.training.schedule import cosine
from arramon_agents.training.trainer import Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl_map.agent import SeeingAgent
from arramon_agents.vl_map.dagger import NAME, train_policy
from arramon_agents.vl_map.placement_network import CellFinder, PlacementNetwork
from arramon_agents.vl_map.policy import MapPolicy, Networks, read_policy, write_policy
from arramon_agents.vl_map.recipe import MapRecipe
from arramon_agents.vl_map.task import PlacementTask
from arramon_agents.weights import SUFFIX, find_weights

LIMITS = """\
- It is trained on generated episodes alone. On people's instructions it reaches less than half of it
  (`docs/results/agents.md`).
- In training its eyes are simulated: the faults are drawn at the rates that were measured on frames of `train`, one
  thing at a time. Things that hide each other, or are cut off at a frame's edge, are not simulated.
- It knows the instruction only as the learned reader read it, mistakes included.
- It looks around at the start and after each walk of three moves, as long as there are steps to spare: it takes more
  actions than an expert.
- In the room it looks around and walks by the rules of `agents.seeing_follower`; the cell is found by its network,
  which knows nothing of ordinals there, and nothing of relations of a landmark itself."""


ROOM_PASSES, ROOM_BATCH, ROOM_RATE, ROOM_DECAY = 30, 64, 0.03, 1e-4
"""Training of the placement network: epochs, batch size, initial learning rate, weight decay."""


def train(recipe: MapRecipe, workspace: Workspace, report: Report) -> Path:
    """Train, resuming from walks and checkpoints if there are any; return the path of the weights.

    The model card is written to the same folder.

    Raises:
        UsageError: if the data folder lacks a split for training or validation.
        ValueError: if a split lacks a language.
        ValueError: if the output folder has walks or a checkpoint of another recipe or other data, or a file to join
            cannot be read.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    found = training_episodes(workspace.data, recipe.languages, recipe.episodes)
    check_validation(workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes)
    joined = [read_policy(find_weights(name)) for name in recipe.join.split(",") if name]
    trained = train_policy(recipe, workspace, report)
    tasks = [task for _, episodes in found for task in room_examples_of(episodes, recipe.languages, load_reader())]
    placer, seconds = train_rooms(tasks, recipe.seed)
    about: dict[str, Any] = {
        "recipe": as_json(recipe),
        "data": trained.description,
        "data_hash": trained.data_hash,
        "updates": trained.updates,
        "cpu_seconds": round(trained.cpu_seconds + seconds),
        "parameters": sum(parameter.numel() for parameter in trained.network.parameters()),
        "room_parameters": sum(parameter.numel() for parameter in placer.parameters()),
        "rooms": len(tasks),
    }
    if joined:
        about["joined"] = [each for _, its in joined for each in (its, *its.get("joined", ()))]
    policies = [trained.network, *(policy for networks, _ in joined for policy in networks.policies)]
    if recipe.validate_episodes:
        plan = RolloutPlan(workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes)
        scores = play(SeeingAgent(MapPolicy(policies), CellFinder(placer)), plan)
        split = {"split": recipe.validate, "episodes": recipe.validate_episodes}
        about["validation"] = split | {name: mean(scores, name) for name in ("nDTW", "CTC-3", "PTC")}
        report(f"{NAME}: validation: {json.dumps(about['validation'])}")
    weights = workspace.output / f"{NAME}{SUFFIX}"
    write_policy(weights, Networks(policies, placer), about)
    weights.with_suffix(".md").write_text(card(about), encoding="utf-8")
    return weights


def train_rooms(tasks: Sequence[RoomExample], seed: int, passes: int = ROOM_PASSES) -> tuple[PlacementNetwork, float]:
    """Train the placement network. This takes less than a minute, so there are no checkpoints.

    Args:
        tasks: training examples.
        seed: seed of initial weights, order, choice of readings, and misnamed objects.
        passes: number of epochs.

    Returns:
        The network, in evaluation mode, and the processor time in seconds.
    """
    torch.manual_seed(seed)
    network = PlacementNetwork()
    steps = max(1, passes * len(tasks) // ROOM_BATCH)
    settings = TrainerSettings("rooms", steps, cosine(ROOM_RATE, steps), seed, decay=ROOM_DECAY, clip=math.inf)
    trainer = Trainer(PlacementTask(network, tasks, ROOM_BATCH, seed), settings)
    trainer.run()
    return network.eval(), trainer.cpu_seconds


def card(about: Mapping[str, Any]) -> str:
    """Return the model card of a policy, in Markdown."""
    recipe = about["recipe"]
    rows = {
        "agent": "`agents.vl_map`. It chooses waypoints on the landmarks and the free ground that it remembers.",
        "model": f"`agents/vl_map/network.py`, {about['parameters']:,} parameters{_averaged(about)}, and "
        f"`placement_network.py`, {about['room_parameters']:,}; with them come the visual encoder `eyes` and the "
        "learned reader",
        "training data": f"{about['data']}, {about['rooms']} rooms; SHA-256 of `train` {about['data_hash'][:12]}",
        "command": f"`{training_command(NAME, recipe, as_json(MapRecipe()))}`",
        "seed": recipe["seed"],
        "updates": about["updates"],
        "CPU time": f"{about['cpu_seconds'] / 60:.0f} minutes, with the walks",
        "validation": _validated(about.get("validation")),
    }
    for number, joined in enumerate(about.get("joined", ()), start=2):
        command = training_command(NAME, joined["recipe"], as_json(MapRecipe()))
        rows[f"policy {number}"] = (
            f"`{command}`, {joined['updates']} updates; {joined['data']}; SHA-256 of `train` {joined['data_hash'][:12]}"
        )
    return model_card(NAME, rows, LIMITS)


def _averaged(about: Mapping[str, Any]) -> str:
    count = 1 + len(about.get("joined", ()))
    return f" for each of {count} policies that are averaged" if count > 1 else ""


def _validated(found: Mapping[str, Any] | None) -> str:
    if not found:
        return "none"
    return (
        f"on the first {found['episodes']} episodes of `{found['split']}`, in each language by turns, after the last "
        f"update: nDTW {found['nDTW']:.3f}, CTC-3 {found['CTC-3']:.3f}, PTC {found['PTC']:.3f}"
    )
