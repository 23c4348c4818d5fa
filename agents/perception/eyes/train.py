"""Training of the visual encoder's two networks on labelled frames."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import torch

from arramon_agents.perception.eyes.encoder import FAR_WEIGHTS, read_networks, write_weights
from arramon_agents.perception.eyes.naming_network import NamingNetwork
from arramon_agents.perception.eyes.network import EyesNetwork, EyesSizes
from arramon_agents.perception.eyes.reach import REACHES
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
        BadWeights: if the file of the network to keep cannot be read.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    sections = [(section, str(city)) for city in range(recipe.cities) for section in SECTIONS]
    frames = FrameSource(sections, recipe.size, recipe.seed)
    table = LabelTable(label_names())
    make: dict[str, Callable[[], TrainingTask]] = {
        "blocks": lambda: BlocksTask(EyesSizes(recipe.size), frames.frame, table, BATCHES["blocks"]),
        "naming": lambda: NamingTask(frames.frame, table, BATCHES["naming"], REACHES[recipe.reach]),
    }
    kept = read_networks(Path(recipe.keep)) if recipe.keep else None
    trainers = []
    for name in NETWORKS:
        torch.manual_seed(recipe.seed)
        trainer = Trainer(make[name](), _settings(name, recipe, workspace), workspace.output, report)
        if recipe.only in ("", name):
            trainer.run()
        else:
            trainer.resume()
        trainers.append(trainer)
    name = FAR_WEIGHTS.name if recipe.reach == "far" else f"vision_eyes{SUFFIX}"
    return _write(trainers, kept, workspace.output / name)


def _settings(name: str, recipe: EyesRecipe, workspace: Workspace) -> TrainerSettings:
    steps = {"blocks": recipe.frames, "naming": recipe.naming_frames}[name] // BATCHES[name]
    settings = asdict(recipe)
    del settings["only"], settings["keep"]
    return TrainerSettings(
        name,
        steps,
        warm_up_cosine(RATES[name], steps),
        recipe.seed,
        decay=DECAY,
        checkpoint_steps=workspace.checkpoint_steps,
        training_inputs=TrainingInputs(settings, json.dumps([*SECTIONS])),
    )


def _write(trainers: Sequence[Trainer], kept: tuple[EyesNetwork, NamingNetwork] | None, path: Path) -> Path | None:
    """Write the weights of both networks, if both are trained to the end or kept, and return the path."""
    is_trained = [trainer.step >= trainer.settings.steps for trainer in trainers]
    if not (all(is_trained) or (kept and any(is_trained))):
        return None
    blocks, naming = (
        trainer.network if done or kept is None else kept[number]
        for number, (trainer, done) in enumerate(zip(trainers, is_trained, strict=True))
    )
    assert isinstance(blocks, EyesNetwork)
    assert isinstance(naming, NamingNetwork)
    write_weights(path, blocks, naming)
    return path
