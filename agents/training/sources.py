"""Training data by split: demonstration sources, loading with progress reports, description and digest."""

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
"""Minimum time between two lines of progress, in seconds."""


def splits_of(split: str, data: Path) -> list[str]:
    """Return the names of the training splits: `train` includes `train_extra` if the data folder has it."""
    return training_splits(data) if split == "train" else [split]


def sources_of(source: DemonstrationSource, rooms: int) -> list[DemonstrationSource]:
    """Return the sources of a training: the split (`train` includes `train_extra`), then generated rooms.

    Args:
        source: source of the split; its number of episodes applies to each split.
        rooms: number of generated rooms; 0 for none.
    """
    sources = [replace(source, split=split) for split in splits_of(source.split, source.data)]
    if rooms:
        sources.append(DemonstrationSource(source.data, ROOMS, source.languages, source.encoder, rooms))
    return sources


def load_demonstrations(
    sources: Sequence[DemonstrationSource], workspace: Workspace, report: Report
) -> Iterator[PhaseDemonstration]:
    """Yield the demonstrations of sources, rendering those that are not cached. All agents share the cache.

    Raises:
        UsageError: if the data folder lacks a split or a language.
    """
    for source in sources:
        began = last_report = time.monotonic()
        count = 0
        for part in collect(source, workspace.cache, workspace.processes):
            yield from part
            count += len(part)
            if time.monotonic() - last_report > REPORT_SECONDS:
                last_report = time.monotonic()
                report(f"{source.split}: {count} demonstrations after {last_report - began:.0f} seconds")


def describe_data(demonstrations: Sequence[PhaseDemonstration], splits: Sequence[str]) -> str:
    """Describe the number of episodes, rooms and steps for a model card."""
    rooms = {each.episode_id for each in demonstrations if each.episode_id.startswith(ROOM_PREFIX)}
    episodes = {each.episode_id for each in demonstrations} - rooms
    steps = sum(len(each.actions) for each in demonstrations)
    return (
        f"{len(episodes)} episodes of {format_split_names(splits)} and {len(rooms)} drawn rooms, "
        f"{steps:,} steps of the expert"
    )


def format_split_names(splits: Sequence[str]) -> str:
    """Format the names of splits for a model card."""
    return " and ".join(f"`{split}`" for split in splits)


def digest_of(demonstrations: Sequence[PhaseDemonstration]) -> str:
    """Return a digest of the demonstrations' episodes, texts and actions, without visual features."""
    digest = hashlib.sha256()
    for each in demonstrations:
        digest.update(repr((each.episode_id, each.turn, each.phase, each.texts)).encode() + each.actions.tobytes())
    return digest.hexdigest()
