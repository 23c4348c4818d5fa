"""The format LeRobotDataset v3.0: Parquet with images, instructions in the tasks file, statistics for normalisation.

Each language of an episode becomes one episode. Images are PNG inside the Parquet files, as video would be lossy.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import datasets
import numpy as np
import pandas as pd

from arramon_dataset.demonstrations.card import card
from arramon_dataset.demonstrations.croissant import CroissantField, CroissantFiles, write_croissant
from arramon_dataset.demonstrations.description import UNITS, shape_of
from arramon_dataset.demonstrations.folder import ExportFolder, as_json
from arramon_dataset.demonstrations.formats import statistics
from arramon_dataset.demonstrations.formats.columns import TableFile, feature_of, sensor_column
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.rendering import RenderedDemonstration, render
from arramon_dataset.demonstrations.request import ResolvedExport
from arramon_dataset.demonstrations.trajectory import PHASES
from arramon_server.episodes.splits import Split

VERSION = "v3.0"

FPS = 1
"""Frames per second: steps have no duration, so each counts as one second."""

FILES_PER_CHUNK = 1000

DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
TASKS, INFO, STATS = "meta/tasks.parquet", "meta/info.json", "meta/stats.json"

KEYS = {
    "rgb": "observation.images.rgb",
    "depth": "observation.depth",
    "segmentation": "observation.segmentation",
    "pose": "observation.state",
}
"""Feature name of each sensor."""

NUMBERS = {
    "observation.turn": ("int64", "1 or 2"),
    "observation.phase": ("int64", "0 navigation, 1 assembly"),
    "observation.steps_left": ("int64", "steps left in the phase"),
    "action": ("int64", "0 forward, 1 left, 2 right, 3 interact"),
    "next.reward": ("float32", "reward of the action"),
    "next.done": ("bool", "whether the action ended the episode"),
    "next.truncated": ("bool", "whether the episode was cut short after the action"),
}
"""Type and meaning of the scalar features."""

INDICES = {
    "timestamp": ("float32", "number of the step in its episode: a step counts as a second"),
    "frame_index": ("int64", "number of the step in its episode"),
    "episode_index": ("int64", "number of the episode"),
    "index": ("int64", "number of the step"),
    "task_index": ("int64", "number of the instruction in meta/tasks.parquet"),
}
"""Type and meaning of the features that LeRobot requires."""


def info_of(export: ResolvedExport, tasks: int) -> dict[str, Any]:
    """Return the content of `meta/info.json`."""
    return {
        "codebase_version": VERSION,
        "robot_type": "arramon",
        "total_episodes": export.episodes,
        "total_frames": export.steps,
        "total_tasks": tasks,
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": FPS,
        "splits": {"train": f"0:{export.episodes}"},
        "data_path": DATA,
        "video_path": None,
        "features": _features(export),
    }


def write_part(export: ResolvedExport, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:  # noqa: ARG001
    """Write a file with all episodes of a part, in each of their languages."""
    place = _place(part.number)
    file = TableFile(made / DATA.format(**place), _hf_features(export))
    episodes: list[dict[str, Any]] = []
    index, number = part.steps_before, part.demonstrations_before
    try:
        for source in part.sources:
            rendered = render(export, source)
            columns, stats = _columns(export, rendered), _statistics(export, rendered)
            for language in source.languages:
                texts = rendered.instructions(language, rendered.action_observations)
                steps = np.arange(rendered.steps)
                file.write(
                    {
                        **columns,
                        "timestamp": steps.astype(np.float32) / FPS,
                        "frame_index": steps,
                        "episode_index": np.full(rendered.steps, number),
                        "index": index + steps,
                        "task_index": [part.tasks[text] for text in texts],
                    }
                )
                episodes.append(
                    {
                        "episode_index": number,
                        "tasks": list(dict.fromkeys(texts)),
                        "length": rendered.steps,
                        "data/chunk_index": place["chunk_index"],
                        "data/file_index": place["file_index"],
                        "dataset_from_index": index,
                        "dataset_to_index": index + rendered.steps,
                        "meta/episodes/chunk_index": 0,
                        "meta/episodes/file_index": 0,
                        "episode_id": source.episode_id,
                        "language": language,
                        "cause": source.cause,
                        "stats": stats,
                    }
                )
                index, number = index + rendered.steps, number + 1
    finally:
        file.close()
    return {"episodes": episodes, "tasks": dict(part.tasks)}


def finish(export: ResolvedExport, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]) -> None:  # noqa: ARG001
    """Write information, tasks, episodes, statistics, card and Croissant file."""
    episodes = [episode for part in parts for episode in part["episodes"]]
    tasks = {text: number for part in parts for text, number in part["tasks"].items()}
    made = folder.scratch("meta")
    tables = {
        TASKS: pd.DataFrame({"task_index": list(tasks.values())}, index=pd.Index(tasks, name="task")),
        EPISODES: pd.DataFrame([_row(episode) for episode in episodes]),
    }
    for name, table in tables.items():
        (made / name).parent.mkdir(parents=True, exist_ok=True)
        table.to_parquet(made / name)
        folder.place(made / name, name)
    stats = {
        key: statistics.combined_statistics([episode["stats"][key] for episode in episodes])
        for key in episodes[0]["stats"]
    }
    folder.write_text(STATS, as_json(stats))
    folder.write_text(INFO, as_json(info_of(export, len(tasks))))
    meanings = {name: meaning for name, (_, meaning) in {**NUMBERS, **INDICES}.items()}
    sensors = {KEYS[name]: f"{UNITS[name][0]}: {UNITS[name][1]}" for name in export.request.sensors}
    metadata = {"configs": [{"config_name": "default", "data_files": "data/*/*.parquet"}]}
    folder.write_text("README.md", card(export, metadata, {**sensors, **meanings}))
    fields = [
        CroissantField(name, _CROISSANT[type_], meaning) for name, (type_, meaning) in {**NUMBERS, **INDICES}.items()
    ]
    if "rgb" in export.request.sensors:
        fields.append(CroissantField(KEYS["rgb"], "sc:ImageObject", UNITS["rgb"][1], path="bytes"))
    write_croissant(export, folder, [CroissantFiles("steps", "data/*/*.parquet", "application/x-parquet", fields)])


_CROISSANT = {"int64": "sc:Integer", "float32": "sc:Float", "bool": "sc:Boolean"}


def _place(part: int) -> dict[str, int]:
    return {"chunk_index": part // FILES_PER_CHUNK, "file_index": part % FILES_PER_CHUNK}


def _features(export: ResolvedExport) -> dict[str, dict[str, Any]]:
    """Return all features as LeRobot describes them."""
    sensors: dict[str, dict[str, Any]] = {}
    for sensor in export.request.sensors:
        is_image = sensor == "rgb"
        names = {"rgb": ["height", "width", "channels"], "pose": ["x", "z", "heading"]}.get(sensor, ["height", "width"])
        sensors[KEYS[sensor]] = {
            "dtype": "image" if is_image else UNITS[sensor][0],
            "shape": list(shape_of(sensor, export.request.size)),
            "names": names,
            "info": {"dtype": UNITS[sensor][0], "unit": UNITS[sensor][1]},
        }
    numbers = {
        name: {"dtype": type_, "shape": [1], "names": None} for name, (type_, _) in {**NUMBERS, **INDICES}.items()
    }
    return {**sensors, **numbers}


def _hf_features(export: ResolvedExport) -> "datasets.Features":
    sensors = {KEYS[sensor]: feature_of(sensor, export.request.size) for sensor in export.request.sensors}
    numbers = {name: datasets.Value(type_) for name, (type_, _) in {**NUMBERS, **INDICES}.items()}
    return datasets.Features({**sensors, **numbers})


def _columns(export: ResolvedExport, rendered: RenderedDemonstration) -> dict[str, Any]:
    """Return the columns that depend on neither the language nor the position in the data set."""
    sensors = {KEYS[sensor]: sensor_column(rendered, sensor) for sensor in export.request.sensors}
    return {**sensors, **_numbers(rendered)}


def _numbers(rendered: RenderedDemonstration) -> dict[str, list[Any]]:
    seen = rendered.action_observations
    return {
        "observation.turn": [each.turn for each in seen],
        "observation.phase": [[phase.value for phase in PHASES].index(each.phase) for each in seen],
        "observation.steps_left": [each.steps_left for each in seen],
        "action": list(rendered.source.actions),
        "next.reward": list(rendered.rewards),
        "next.done": rendered.terminated(),
        "next.truncated": rendered.truncated(),
    }


def _statistics(export: ResolvedExport, rendered: RenderedDemonstration) -> dict[str, statistics.Statistics]:
    """Return the statistics of an episode, without depth and segmentation, whose statistics are as large as frames."""
    found = {
        name: statistics.numeric_statistics(np.asarray(values)[:, None]) for name, values in _numbers(rendered).items()
    }
    if "pose" in export.request.sensors:
        found[KEYS["pose"]] = statistics.numeric_statistics(
            np.asarray([each.pose for each in rendered.action_observations])
        )
    if "rgb" in export.request.sensors:
        found[KEYS["rgb"]] = statistics.frame_statistics(
            [each.rgb for each in rendered.action_observations if each.rgb is not None]
        )
    return found


def _row(episode: Mapping[str, Any]) -> dict[str, Any]:
    stats = {f"stats/{key}/{name}": value for key, its in episode["stats"].items() for name, value in its.items()}
    return {**{name: value for name, value in episode.items() if name != "stats"}, **stats}
