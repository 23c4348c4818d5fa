"""Training of `vl_grounded`: demonstrations, both networks, validation by rollouts, weights and model card."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from arramon_agents.perception.encoder import DEFAULT
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.reader import WEIGHTS as READER
from arramon_agents.reading.reader.reader import read_reader
from arramon_agents.reading.tokenizers import Words
from arramon_agents.training.batches import epoch
from arramon_agents.training.card import command_with, learned_from, page
from arramon_agents.training.demonstrations import (
    ROOM_PREFIX,
    ROOMS,
    Demonstration,
    Source,
    collect,
    data_hash_of,
)
from arramon_agents.training.exchange import Version, versions
from arramon_agents.training.rollouts import Plan as Rollouts
from arramon_agents.training.rollouts import mean, play
from arramon_agents.training.run import train
from arramon_agents.training.sources import digest_of, named, sources_of, splits_of
from arramon_agents.training.trainer import Plan, Trainer
from arramon_agents.vl.recipe import Place
from arramon_agents.vl_grounded.agent import NAME, GroundedAgent
from arramon_agents.vl_grounded.network import Grounded, Weights, read_weights, write_weights
from arramon_agents.vl_grounded.room_views import RoomView, collect_views
from arramon_agents.vl_grounded.sight import EncodedSight
from arramon_agents.vl_grounded.task import GroundedTask, Placing, Walk
from arramon_agents.vl_grounded.words import begin, known_words, widened
from arramon_agents.weights import SUFFIX, find_initial
from arramon_client.environments.backend import ASSEMBLY, NAVIGATION

Tell = Callable[[str], None]

DECAY = 0.01
"""Weight decay."""

LIMITS = """\
- In the streets it sees one image at a time, and remembers places only as far as its LSTM does.
- It learned from the expert's own walks: once off the path it has never seen what to do, and turn 2 begins where turn 1
  ended.
- In the room it looks around once, from the start tile; what is hidden from there it does not know of."""


@dataclass(frozen=True)
class GroundedRecipe:
    """All settings of a training.

    Attributes:
        languages: in which instructions are read.
        split, every, episodes, init: as in `arramon_agents.vl.recipe.Recipe`. With `train`,
            `train_extra` is learned from as well if the data folder has it.
        rooms: number of generated tasks in the room alone, besides.
        versions, room_versions: number of variants of each walk's and each room's instruction, with other things.
        passes: number of passes over the walks.
        batch: number of walks in a step; twice as many rooms.
        learning_rate: the highest.
        inflection: weight of the steps at which the expert's action changes; the others have 1.
        seed: of everything.
        validate: split for validation at the end.
        validate_episodes: number of its first episodes to play; 0 for none.
    """

    languages: tuple[str, ...] = ("en", "hi")
    split: str = "train"
    every: int = 1
    episodes: int = 0
    init: str = ""
    rooms: int = 600
    versions: int = 2
    room_versions: int = 1
    passes: int = 24
    batch: int = 32
    learning_rate: float = 2e-3
    inflection: float = 2.5
    seed: int = 1
    validate: str = "val_seen"
    validate_episodes: int = 20


def smoke(recipe: GroundedRecipe) -> GroundedRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, episodes=4, rooms=0, versions=1, passes=2, batch=4, validate_episodes=1)


def train_grounded(recipe: GroundedRecipe, place: Place, tell: Tell) -> Path:
    """Train, resuming from a saved state if there is one; return the path of the weights (the card is beside it).

    Raises:
        UsageError: if the data folder does not have what the recipe names.
        ValueError: if the output folder holds a state of another recipe or other data.
    """
    prepare_process()
    place.output.mkdir(parents=True, exist_ok=True)
    learned = Source(place.data, recipe.split, recipe.languages, DEFAULT, recipe.episodes, every=recipe.every)
    sources = sources_of(learned, recipe.rooms)
    demonstrations = [
        each
        for source in sources
        if source.split != ROOMS
        for part in collect(source, place.cache, place.processes)
        for each in part
        if each.phase == NAVIGATION
    ]
    tell(f"{NAME}: {len(demonstrations)} walks")
    views = [view for source in sources for part in collect_views(source, place.cache) for view in part]
    tell(f"{NAME}: {len(views)} rooms")
    walks, placings = _versions(recipe, demonstrations, views)
    said = [each.versions for each in walks] + [each.versions for each in placings]
    texts = [version.texts for each in said for version in each]
    tokenizer, make_network = _beginning(recipe, [text for each in texts for text in each.values()])
    tell(f"{NAME}: {len(texts)} instructions in each language, {tokenizer.size} words")

    def make_task() -> GroundedTask:
        return GroundedTask(
            make_network(), tokenizer, recipe.languages, walks, placings, recipe.batch, recipe.inflection, recipe.seed
        )

    trainer = Trainer(_plan(recipe, demonstrations, views), make_task)
    train(trainer, place.output, NAME)
    grounded = trainer.network
    assert isinstance(grounded, Grounded)
    eyes = load_eyes()
    weights = Weights(grounded.eval(), tokenizer, eyes.fingerprint, {})
    about: dict[str, Any] = {
        "recipe": asdict(recipe) | {"languages": list(recipe.languages)},
        "data": _data_of(splits_of(recipe.split, place.data), demonstrations, views),
        "data_hash": data_hash_of(sources[0]),
        "updates": trainer.done,
        "cpu_seconds": round(trainer.seconds),
        "parameters": sum(parameter.numel() for parameter in grounded.parameters()),
    }
    if recipe.validate_episodes:
        rollouts = Rollouts(place.data, recipe.validate, recipe.languages, recipe.validate_episodes, eyes.image_size)
        scores = play(GroundedAgent(weights, EncodedSight(eyes)), rollouts)
        about["validation"] = {name: mean(scores, name) for name in ("nDTW", "CTC-3", "PTC")}
        tell(f"{NAME}: validation: {json.dumps(about['validation'])}")
    path = place.output / f"{NAME}{SUFFIX}"
    write_weights(path, replace(weights, about=about))
    path.with_suffix(".md").write_text(card(about), encoding="utf-8")
    return path


def _beginning(recipe: GroundedRecipe, texts: Sequence[str]) -> tuple[Words, Callable[[], Grounded]]:
    """Return the words, and what makes the network: from the reader, or from weights that are fine-tuned."""
    if recipe.init:
        words, network = widened(read_weights(find_initial(recipe.init, NAME)), texts)
        return words, lambda: network
    reader, vocabulary = read_reader(READER)
    words = known_words(texts, vocabulary)

    def make() -> Grounded:
        grounded = Grounded(words.size)
        begin(grounded.reading, words, reader, vocabulary)
        return grounded

    return words, make


def _versions(
    recipe: GroundedRecipe, demonstrations: Sequence[Demonstration], views: Sequence[RoomView]
) -> tuple[list[Walk], list[Placing]]:
    """Return walks and rooms with the versions of their instructions."""

    def written(each: Demonstration | RoomView, phase: str, count: int) -> list[Version]:
        seed = f"{recipe.seed}/{phase}/{each.episode_id}/{each.turn}"
        return versions(each.texts, phase, recipe.languages, count, seed)

    walks = [Walk.of(each, written(each, NAVIGATION, recipe.versions)) for each in demonstrations]
    return walks, [Placing(view, written(view, ASSEMBLY, recipe.room_versions)) for view in views]


def _plan(recipe: GroundedRecipe, demonstrations: Sequence[Demonstration], views: Sequence[RoomView]) -> Plan:
    learned = {name: value for name, value in asdict(recipe).items() if not name.startswith("validate")}
    steps = recipe.passes * len(epoch(demonstrations, NAVIGATION, recipe.batch, ""))
    return Plan(
        samples=steps * recipe.batch,
        batch=recipe.batch,
        rate=recipe.learning_rate,
        decay=DECAY,
        seed=recipe.seed,
        about=json.dumps([learned, digest_of(demonstrations), len(views)]),
    )


def _data_of(splits: Sequence[str], demonstrations: Sequence[Demonstration], views: Sequence[RoomView]) -> str:
    """Return a description of the number of episodes, steps and rooms."""
    episodes = len({each.episode_id for each in demonstrations})
    steps = sum(len(each.actions) for each in demonstrations)
    drawn = sum(view.episode_id.startswith(ROOM_PREFIX) for view in views)
    return (
        f"{episodes} episodes of {named(splits)}, {steps:,} steps of the expert in the streets, "
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
        "command": f"`{command_with(NAME, recipe, asdict(GroundedRecipe()))}`",
        "seed": recipe["seed"],
        "updates": about["updates"],
        "CPU time": f"{about['cpu_seconds'] / 60:.0f} minutes, without drawing the demonstrations",
        "validation": _validated(about.get("validation"), recipe),
    }
    return page(NAME, rows, f"{learned_from(recipe['split'], recipe['init'])}\n{LIMITS}")


def _validated(found: Mapping[str, float] | None, recipe: Mapping[str, Any]) -> str:
    if not found:
        return "none"
    scores = ", ".join(f"{name} {value:.3f}" for name, value in found.items())
    return (
        f"on the first {recipe['validate_episodes']} episodes of `{recipe['validate']}`, in each language by turns, "
        f"after the last update: {scores}"
    )
