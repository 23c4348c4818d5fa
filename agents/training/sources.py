"""Sources of demonstrations by split, their progress while they are drawn, and their description and digest."""

import hashlib
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from arramon_agents.simulated.courses import training_splits
from arramon_agents.training.demonstrations import (
    ROOM_PREFIX,
    ROOMS,
    DemonstrationSource,
    PhaseDemonstration,
    collect,
)
from arramon_agents.training.workspace import Report, Workspace

REPORT_SECONDS = 20.0
"""Least time between two lines of progress."""


def splits_of(split: str, data: Path) -> list[str]:
    """Return the names of the splits that are learned from: with `train` also `train_extra`, if the folder has it."""
    return training_splits(data) if split == "train" else [split]


def sources_of(source: DemonstrationSource, rooms: int) -> list[DemonstrationSource]:
    """Return what is learned from: the source's split, with `train` also `train_extra`, then drawn rooms.

    `train_extra` is learned from if the data folder has it, with as many episodes at most.

    Args:
        source: the split to learn from.
        rooms: number of drawn rooms; 0 for none.
    """
    sources = [replace(source, split=split) for split in splits_of(source.split, source.data)]
    if rooms:
        sources.append(DemonstrationSource(source.data, ROOMS, source.languages, source.encoder, rooms))
    return sources


def load_demonstrations(
    sources: Sequence[DemonstrationSource], workspace: Workspace, report: Report
) -> Iterator[PhaseDemonstration]:
    """Yield the demonstrations of sources, rendering those that are not in the cache, which all agents share.

    Raises:
        UsageError: if the data folder does not have what a source names.
    """
    for source in sources:
        began = told = time.monotonic()
        count = 0
        for part in collect(source, workspace.cache, workspace.processes):
            yield from part
            count += len(part)
            if time.monotonic() - told > REPORT_SECONDS:
                told = time.monotonic()
                report(f"{source.split}: {count} demonstrations after {told - began:.0f} seconds")


def describe_data(demonstrations: Sequence[PhaseDemonstration], splits: Sequence[str]) -> str:
    """Return how many episodes, rooms and steps there are, in words."""
    rooms = {each.episode_id for each in demonstrations if each.episode_id.startswith(ROOM_PREFIX)}
    episodes = {each.episode_id for each in demonstrations} - rooms
    steps = sum(len(each.actions) for each in demonstrations)
    return (
        f"{len(episodes)} episodes of {split_names(splits)} and {len(rooms)} drawn rooms, {steps:,} steps of the expert"
    )


def split_names(splits: Sequence[str]) -> str:
    """Return the splits' names as a model card has them."""
    return " and ".join(f"`{split}`" for split in splits)


def digest_of(demonstrations: Sequence[PhaseDemonstration]) -> str:
    """Return a digest of the demonstrations: episodes, texts and actions, without images."""
    digest = hashlib.sha256()
    for each in demonstrations:
        digest.update(repr((each.episode_id, each.turn, each.phase, each.texts)).encode() + each.actions.tobytes())
    return digest.hexdigest()
