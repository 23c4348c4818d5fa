"""The plain format: actions, poses and texts as JSON Lines, without frames; `arramon_client.demonstrations` reads it.

For training in this project: rendering a frame takes less time than reading one.
"""

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from arramon_dataset.demonstrations.croissant import CroissantField, CroissantFiles, write_croissant
from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.request import ResolvedExport
from arramon_dataset.demonstrations.sources import EpisodeActions
from arramon_dataset.demonstrations.trajectory import replay_demonstration
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.worlds import Worlds

FILES = "demonstrations-*.jsonl"

FIELDS = (
    CroissantField("episode_id", "sc:Text", "id of the episode in its split"),
    CroissantField("section", "sc:Text", "section of the city"),
    CroissantField("cause", "sc:Text", "why the episode ended"),
    CroissantField("finished", "sc:Boolean", "whether the actions end the episode"),
)


def write_part(export: ResolvedExport, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:
    """Write one line for each episode; all languages share it."""
    worlds = _worlds(split)
    with (made / f"demonstrations-{part.number:05d}-of-{export.parts:05d}.jsonl").open("w", encoding="utf-8") as file:
        for source in part.sources:
            file.write(json.dumps(_line(export, split, source, worlds), ensure_ascii=False) + "\n")
    return {}


def finish(export: ResolvedExport, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]) -> None:  # noqa: ARG001
    """Write the Croissant file."""
    write_croissant(export, folder, (CroissantFiles("demonstrations", FILES, "application/jsonlines", FIELDS),))


def _line(export: ResolvedExport, split: Split, source: EpisodeActions, worlds: Worlds) -> dict[str, Any]:
    episode = split.episodes[source.episode_id]
    trajectory = replay_demonstration(source, episode, worlds.world(split.name, episode), export.steps_per_phase)
    return {
        "episode_id": episode.episode_id,
        "section": episode.section,
        "instructions": {
            language: [[turn.navigation, turn.assembly] for turn in episode.instructions[language]]
            for language in source.languages
        },
        "actions": list(source.actions),
        "turns": trajectory.turns,
        "phases": trajectory.phases,
        "poses": trajectory.poses,
        "cause": source.cause,
        "finished": trajectory.finished,
        "scores": trajectory.scores,
    }


@lru_cache(maxsize=1)
def _worlds(split: Split) -> Worlds:
    return Worlds({split.name: split})
