"""Training of the visual encoder's two networks on labelled frames."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import torch

from arramon_agents.perception.eyes.encoder import write_weights
from arramon_agents.perception.eyes.naming_network import NamingNetwork
from arramon_agents.perception.eyes.network import EyesNetwork, EyesSizes
from arramon_agents.perception.eyes.recipe import NETWORKS, EyesRecipe
from arramon_agents.perception.eyes.targets import LabelTable
from arramon_agents.perception.eyes.tasks import BlocksTask, NamingTask
from arramon_agents.process_settings import prepare_process
from arramon_agents.simulated.frames import FrameSource, label_names
from arramon_agents.training.checkpoint import TrainingInputs
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Trainer, TrainerSettings, TrainingTask
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.weights import SUFFIX

SECTIONS = ("1", "2", "3", "4", "5")
"""Sections of the training splits."""

BATCHES = {"blocks": 8, "naming": 24}
"""Number of frames in a batch of each network."""

RATES = {"blocks": 0.002, "naming": 0.003}
"""Peak learning rate of each network."""

DECAY = 0.0001
"""Weight decay."""


def train(recipe: EyesRecipe, workspace: Workspace, report: Report) -> Path | None:
    """Train the networks of a recipe, resuming from checkpoints if there are any.

    Returns:
        Path of the weights, which are written once both networks are trained; None before that.

    Raises:
        ValueError: if the output folder holds a checkpoint of another recipe.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    sections = [(section, str(city)) for city in range(recipe.cities) for section in SECTIONS]
    frames = FrameSource(sections, recipe.size, recipe.seed)
    table = LabelTable(label_names())
    make: dict[str, Callable[[], TrainingTask]] = {
        "blocks": lambda: BlocksTask(EyesSizes(recipe.size), frames.frame, table, BATCHES["blocks"]),
        "naming": lambda: NamingTask(frames.frame, table, BATCHES["naming"]),
    }
    trainers = []
    for name in NETWORKS:
        torch.manual_seed(recipe.seed)
        trainer = Trainer(make[name](), _settings(name, recipe, workspace), workspace.output, report)
        if recipe.only in ("", name):
            trainer.run()
        else:
            trainer.resume()
        trainers.append(trainer)
    return _write(trainers, workspace.output / f"vision_eyes{SUFFIX}")


def _settings(name: str, recipe: EyesRecipe, workspace: Workspace) -> TrainerSettings:
    steps = {"blocks": recipe.frames, "naming": recipe.naming_frames}[name] // BATCHES[name]
    settings = asdict(recipe)
    del settings["only"]
    return TrainerSettings(
        name,
        steps,
        warm_up_cosine(RATES[name], steps),
        recipe.seed,
        decay=DECAY,
        checkpoint_steps=workspace.checkpoint_steps,
        training_inputs=TrainingInputs(settings, json.dumps([*SECTIONS])),
    )


def _write(trainers: Sequence[Trainer], path: Path) -> Path | None:
    """Write the weights of both networks, if both are trained to the end, and return the path."""
    if any(trainer.step < trainer.settings.steps for trainer in trainers):
        return None
    blocks, naming = (trainer.network for trainer in trainers)
    assert isinstance(blocks, EyesNetwork)
    assert isinstance(naming, NamingNetwork)
    write_weights(path, blocks, naming)
    return path
