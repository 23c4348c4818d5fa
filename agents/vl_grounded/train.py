"""Training of `vl_grounded`: demonstrations, training loop, validation by rollouts, weights and model card."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from arramon_agents.perception.encoder import DEFAULT
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.reader import WEIGHTS as READER
from arramon_agents.reading.reader.reader import read_reader
from arramon_agents.reading.tokenizers import PolicyWordTokenizer
from arramon_agents.training.card import model_card, training_command, training_text_limit
from arramon_agents.training.checkpoint import TrainingInputs, check_recipe
from arramon_agents.training.demonstrations import (
    ROOM_PREFIX,
    ROOMS,
    DemonstrationSource,
    PhaseDemonstration,
    data_hash_of,
)
from arramon_agents.training.name_permutation import InstructionVersion, instruction_versions
from arramon_agents.training.recipe import as_json, update_settings
from arramon_agents.training.rollouts import RolloutPlan, check_validation, mean, play
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.sources import digest_of, format_split_names, load_demonstrations, sources_of, splits_of
from arramon_agents.training.trainer import Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl_grounded.agent import NAME, GroundedAgent
from arramon_agents.vl_grounded.initial_vocabulary import (
    extended_weights,
    initialise_from_reader,
    tokenizer_with_reader,
)
from arramon_agents.vl_grounded.network import Grounded, GroundedWeights, read_weights, write_weights
from arramon_agents.vl_grounded.perception import EncoderPerception
from arramon_agents.vl_grounded.recipe import GroundedRecipe
from arramon_agents.vl_grounded.room_views import RoomView, collect_views
from arramon_agents.vl_grounded.task import DemonstratedPlacement, DemonstratedWalk, GroundedTask
from arramon_agents.weights import SUFFIX, find_initial
from arramon_client.world import ASSEMBLY, NAVIGATION

DECAY = 0.01
"""Weight decay."""

LIMITS = """\
- In the streets it sees one image at a time, and remembers places only as far as its LSTM does.
- It learned from the expert's own walks: once off the path it has never seen what to do, and turn 2 begins where turn 1
  ended.
- In the room it looks around once, from the start tile; what is hidden from there it does not know of."""


def train(recipe: GroundedRecipe, workspace: Workspace, report: Report) -> Path:
    """Train, resuming from a checkpoint if there is one; write weights and model card; return the path of the weights.

    Raises:
        UsageError: if the data folder does not have what the recipe names, the split for validation included.
        ValueError: if the output folder holds a checkpoint of another recipe or other data.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    learned = DemonstrationSource(
        workspace.data, recipe.split, recipe.languages, DEFAULT, recipe.episodes, every=recipe.every
    )
    sources = sources_of(learned, recipe.rooms)
    check_recipe(workspace.output, NAME, update_settings(recipe))
    data_hash = data_hash_of(sources[0])
    check_validation(workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes)
    streets = [source for source in sources if source.split != ROOMS]
    demonstrations = [each for each in load_demonstrations(streets, workspace, report) if each.phase == NAVIGATION]
    report(f"{NAME}: {len(demonstrations)} walks")
    views = [view for source in sources for part in collect_views(source, workspace.cache) for view in part]
    report(f"{NAME}: {len(views)} rooms")
    walks, placings = _versions(recipe, demonstrations, views)
    tokenizer, network = _initial_network(recipe, walks, placings, report)
    task = GroundedTask(
        network.to(workspace.device),
        tokenizer,
        recipe.languages,
        walks,
        placings,
        recipe.batch,
        recipe.inflection,
        recipe.seed,
        workspace.device,
    )
    data = f"{digest_of(demonstrations)}, {len(views)} rooms"
    trainer = Trainer(task, _settings(recipe, workspace, task.epoch_steps, data), workspace.output, report)
    trainer.run()
    eyes = load_eyes()
    weights = GroundedWeights(network.cpu().eval(), tokenizer, eyes.fingerprint, {})
    about: dict[str, Any] = {
        "recipe": as_json(recipe),
        "data": _data_of(splits_of(recipe.split, workspace.data), demonstrations, views),
        "data_hash": data_hash,
        "updates": trainer.step,
        "cpu_seconds": round(trainer.cpu_seconds),
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
    }
    if recipe.validate_episodes:
        rollouts = RolloutPlan(
            workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes, eyes.image_size
        )
        scores = play(GroundedAgent(weights, EncoderPerception(eyes)), rollouts)
        about["validation"] = {name: mean(scores, name) for name in ("nDTW", "CTC-3", "PTC")}
        report(f"{NAME}: validation: {json.dumps(about['validation'])}")
    path = workspace.output / f"{NAME}{SUFFIX}"
    write_weights(path, replace(weights, about=about))
    path.with_suffix(".md").write_text(card(about), encoding="utf-8")
    return path


def _initial_network(
    recipe: GroundedRecipe, walks: Sequence[DemonstratedWalk], placings: Sequence[DemonstratedPlacement], report: Report
) -> tuple[PolicyWordTokenizer, Grounded]:
    """Return tokenizer and network before the first update: initialised from the reader, or weights to fine-tune."""
    said = [*(walk.versions for walk in walks), *(placing.versions for placing in placings)]
    written = [version.texts for each in said for version in each]
    texts = [text for each in written for text in each.values()]
    if recipe.init:
        words, network = extended_weights(read_weights(find_initial(recipe.init, NAME)), texts)
    else:
        reader, vocabulary = read_reader(READER)
        words = tokenizer_with_reader(texts, vocabulary)
        torch.manual_seed(recipe.seed)
        network = Grounded(words.size)
        initialise_from_reader(network.reading, words, reader, vocabulary)
    report(f"{NAME}: {len(written)} instructions in each language, {words.size} words")
    return words, network


def _versions(
    recipe: GroundedRecipe, demonstrations: Sequence[PhaseDemonstration], views: Sequence[RoomView]
) -> tuple[list[DemonstratedWalk], list[DemonstratedPlacement]]:
    """Return walks and rooms with the augmented versions of their instructions."""

    def written(each: PhaseDemonstration | RoomView, phase: str, count: int) -> list[InstructionVersion]:
        seed = f"{recipe.seed}/{phase}/{each.episode_id}/{each.turn}"
        return instruction_versions(each.texts, phase, recipe.languages, count, seed)

    walks = [DemonstratedWalk.of(each, written(each, NAVIGATION, recipe.versions)) for each in demonstrations]
    return walks, [DemonstratedPlacement(view, written(view, ASSEMBLY, recipe.room_versions)) for view in views]


def _settings(recipe: GroundedRecipe, workspace: Workspace, epoch_steps: int, data: str) -> TrainerSettings:
    steps = recipe.passes * epoch_steps
    return TrainerSettings(
        NAME,
        steps,
        warm_up_cosine(recipe.learning_rate, steps),
        recipe.seed,
        decay=DECAY,
        checkpoint_steps=workspace.checkpoint_steps,
        training_inputs=TrainingInputs(update_settings(recipe), data),
    )


def _data_of(splits: Sequence[str], demonstrations: Sequence[PhaseDemonstration], views: Sequence[RoomView]) -> str:
    """Describe the training data: numbers of episodes, steps and rooms."""
    episodes = len({each.episode_id for each in demonstrations})
    steps = sum(len(each.actions) for each in demonstrations)
    drawn = sum(view.episode_id.startswith(ROOM_PREFIX) for view in views)
    return (
        f"{episodes} episodes of {format_split_names(splits)}, {steps:,} steps of the expert in the streets, "
        f"and {len(views):,} rooms, {drawn:,} of them drawn alone"
    )


def card(about: Mapping[str, Any]) -> str:
    """Return the model card, in Markdown."""
    recipe = about["recipe"]
    rows = {
        "agent": "`agents.vl_grounded`. It reads on as it walks, and scores what it sees by what it has read.",
        "model": f"`agents/vl_grounded/network.py`, {about['parameters']:,} parameters; with it comes the visual "
        "encoder `eyes`",
        "training data": f"{about['data']}; SHA-256 of `{recipe['split']}` {about['data_hash'][:12]}",
        "command": f"`{training_command(NAME, recipe, as_json(GroundedRecipe()))}`",
        "seed": recipe["seed"],
        "updates": about["updates"],
        "CPU time": f"{about['cpu_seconds'] / 60:.0f} minutes, without drawing the demonstrations",
        "validation": _validated(about.get("validation"), recipe),
    }
    return model_card(NAME, rows, f"{training_text_limit(recipe['split'], recipe['init'])}\n{LIMITS}")


def _validated(found: Mapping[str, float] | None, recipe: Mapping[str, Any]) -> str:
    if not found:
        return "none"
    scores = ", ".join(f"{name} {value:.3f}" for name, value in found.items())
    return (
        f"on the first {recipe['validate_episodes']} episodes of `{recipe['validate']}`, in each language by turns, "
        f"after the last update: {scores}"
    )
