"""What a recipe learns from: the demonstrations of its sources, and what model cards and checkpoints say of them."""

import hashlib
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from arramon_agents.simulated.courses import training_splits
from arramon_agents.training.demonstrations import (
    ROOM_PREFIX,
    ROOMS,
    Demonstration,
    Source,
    collect,
    data_hash_of,
    unseen,
)
from arramon_agents.vl.recipe import Place, Recipe

Tell = Callable[[str], None]

TELL_SECONDS = 20.0
"""Least time between two lines of progress."""


def splits_of(split: str, data: Path) -> list[str]:
    """Return the names of the splits that are learned from: with `train` also `train_extra`, if the folder has it."""
    return training_splits(data) if split == "train" else [split]


def sources_of(source: Source, rooms: int) -> list[Source]:
    """Return what is learned from: the source's split, with `train` also `train_extra`, then drawn rooms.

    `train_extra` is learned from if the data folder has it, with as many episodes at most.

    Args:
        source: the split to learn from.
        rooms: number of drawn rooms; 0 for none.
    """
    sources = [replace(source, split=split) for split in splits_of(source.split, source.data)]
    if rooms:
        sources.append(Source(source.data, ROOMS, source.languages, source.encoder, rooms))
    return sources


def demonstrations_of(recipe: Recipe, place: Place, tell: Tell = lambda _: None) -> list[Demonstration]:
    """Return the demonstrations of a recipe, rendering those that are not cached.

    All agents share one cache of image features. For an agent without images the features are left out.

    Raises:
        UsageError: if the data folder does not have what the recipe names.
    """
    found: list[Demonstration] = []
    learned = Source(place.data, recipe.split, recipe.texts, recipe.encoder, recipe.episodes, every=recipe.every)
    for source in sources_of(learned, recipe.rooms):
        before = told = time.monotonic()
        for part in collect(source, place.cache, place.processes):
            found += part if recipe.sees else [unseen(each) for each in part]
            if time.monotonic() - told > TELL_SECONDS:
                told = time.monotonic()
                tell(f"{source.split}: {len(found)} demonstrations after {told - before:.0f} seconds")
    return found


def train_data_hash(recipe: Recipe, place: Place) -> str:
    """Return the hash of the training split.

    Raises:
        UsageError: if the data folder does not have it, or not the recipe's first language.
    """
    return data_hash_of(Source(place.data, recipe.split, recipe.languages, "", 0))


def data_of(demonstrations: Sequence[Demonstration], splits: Sequence[str]) -> str:
    """Return how many episodes, rooms and steps there are, in words."""
    rooms = {each.episode_id for each in demonstrations if each.episode_id.startswith(ROOM_PREFIX)}
    episodes = {each.episode_id for each in demonstrations} - rooms
    steps = sum(len(each.actions) for each in demonstrations)
    return f"{len(episodes)} episodes of {named(splits)} and {len(rooms)} drawn rooms, {steps:,} steps of the expert"


def named(splits: Sequence[str]) -> str:
    """Return the splits' names as a model card has them."""
    return " and ".join(f"`{split}`" for split in splits)


def digest_of(demonstrations: Sequence[Demonstration]) -> str:
    """Return a digest of the demonstrations: episodes, texts and actions, without images."""
    digest = hashlib.sha256()
    for each in demonstrations:
        digest.update(repr((each.episode_id, each.turn, each.phase, each.texts)).encode() + each.actions.tobytes())
    return digest.hexdigest()
