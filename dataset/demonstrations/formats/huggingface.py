"""The Hugging Face format: Parquet with one row for each step, a split for each language, and a dataset card."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import datasets
from datasets.info import DatasetInfosDict
from huggingface_hub import DatasetCardData

from arramon_dataset.demonstrations.card import card
from arramon_dataset.demonstrations.croissant import CroissantField, CroissantFiles, write_croissant
from arramon_dataset.demonstrations.description import ACTIONS, UNITS
from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.formats.columns import TableFile, feature_of, sensor_column
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.rendering import RenderedDemonstration, render
from arramon_dataset.demonstrations.request import ResolvedExport
from arramon_dataset.demonstrations.trajectory import PHASES
from arramon_server.episodes.splits import Split

COLUMNS = {
    "episode_id": ("sc:Text", "id of the episode in its split"),
    "step": ("sc:Integer", "number of the step in the episode, from 0"),
    "turn": ("sc:Integer", "1 or 2"),
    "phase": ("sc:Integer", "0 navigation, 1 assembly"),
    "steps_left": ("sc:Integer", "steps left in the phase"),
    "instruction": ("sc:Text", "instruction of the turn and phase"),
    "action": ("sc:Integer", "action taken: " + ", ".join(f"{i} {name}" for i, name in enumerate(ACTIONS))),
    "reward": ("sc:Float", "reward of the action"),
    "phase_ended": ("sc:Boolean", "whether the action ended the phase"),
    "terminated": ("sc:Boolean", "whether the action ended the episode"),
    "truncated": ("sc:Boolean", "whether the episode was cut short after the action"),
}
"""Croissant type and meaning of each column except the sensors."""


def features_of(export: ResolvedExport) -> "datasets.Features":
    """Return the features of the columns."""
    request = export.request
    return datasets.Features({
        "episode_id": datasets.Value("string"),
        "step": datasets.Value("int32"),
        "turn": datasets.Value("int8"),
        "phase": datasets.ClassLabel(names=[phase.value for phase in PHASES]),
        "steps_left": datasets.Value("int32"),
        "instruction": datasets.Value("string"),
        **{sensor: feature_of(sensor, request.size) for sensor in request.sensors},
        "action": datasets.ClassLabel(names=list(ACTIONS)),
        "reward": datasets.Value("float64"),
        "phase_ended": datasets.Value("bool"),
        "terminated": datasets.Value("bool"),
        "truncated": datasets.Value("bool"),
    })  # fmt: skip


def write_part(export: ResolvedExport, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:  # noqa: ARG001
    """Write a file for each language; frames are rendered and encoded once for all languages."""
    files: dict[str, TableFile] = {}
    counts = dict.fromkeys(export.request.languages, 0)
    names = {code: f"data/{code}-{part.number:05d}-of-{export.parts:05d}.parquet" for code in counts}
    try:
        for source in part.sources:
            rendered = render(export, source)
            columns = _columns(export, rendered)
            for code in source.languages:
                if code not in files:
                    files[code] = TableFile(made / names[code], features_of(export))
                files[code].write({**columns, "instruction": rendered.instructions(code, rendered.action_observations)})
                counts[code] += rendered.steps
    finally:
        for file in files.values():
            file.close()
    bytes_of = {code: (made / names[code]).stat().st_size for code in files}
    return {"rows": counts, "bytes": bytes_of}


def finish(export: ResolvedExport, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]) -> None:  # noqa: ARG001
    """Write the dataset card and the Croissant file."""
    rows = {code: sum(part["rows"][code] for part in parts) for code in export.request.languages}
    there = [code for code in export.request.languages if rows[code]]
    sizes = {code: sum(part["bytes"].get(code, 0) for part in parts) for code in there}
    metadata = {
        "configs": [
            {
                "config_name": "default",
                "data_files": [{"split": code, "path": f"data/{code}-*.parquet"} for code in there],
            }
        ],
        "dataset_info": {
            "features": _features_of_card(export),
            "splits": [{"name": code, "num_bytes": sizes[code], "num_examples": rows[code]} for code in there],
            "download_size": sum(sizes.values()),
            "dataset_size": sum(sizes.values()),
        },
    }
    folder.write_text("README.md", card(export, metadata, _columns_in_words(export)))
    fields = _fields(export)
    write_croissant(
        export,
        folder,
        [CroissantFiles(code, f"data/{code}-*.parquet", "application/x-parquet", fields) for code in there],
    )


def _columns(export: ResolvedExport, rendered: RenderedDemonstration) -> dict[str, Any]:
    """Return the columns that do not depend on the language."""
    seen = rendered.action_observations
    return {
        "episode_id": [rendered.source.episode_id] * rendered.steps,
        "step": [each.step for each in seen],
        "turn": [each.turn for each in seen],
        "phase": [[phase.value for phase in PHASES].index(each.phase) for each in seen],
        "steps_left": [each.steps_left for each in seen],
        **{sensor: sensor_column(rendered, sensor) for sensor in export.request.sensors},
        "action": list(rendered.source.actions),
        "reward": list(rendered.rewards),
        "phase_ended": list(rendered.phases_ended),
        "terminated": rendered.terminated(),
        "truncated": rendered.truncated(),
    }


def _fields(export: ResolvedExport) -> list[CroissantField]:
    """Return the columns that Croissant's types can express: all except arrays."""
    fields = [CroissantField(name, type_, meaning) for name, (type_, meaning) in COLUMNS.items()]
    if "rgb" in export.request.sensors:
        fields.append(CroissantField("rgb", "sc:ImageObject", UNITS["rgb"][1], path="bytes"))
    return fields


def _features_of_card(export: ResolvedExport) -> Any:
    """Return the features for the card: without it, loaders would take an array for lists of lists."""
    info = datasets.DatasetInfo(features=features_of(export), config_name="default")
    card_data = DatasetCardData()
    DatasetInfosDict({"default": info}).to_dataset_card_data(card_data)
    return card_data["dataset_info"]["features"]


def _columns_in_words(export: ResolvedExport) -> dict[str, str]:
    sensors = {sensor: f"{UNITS[sensor][0]}: {UNITS[sensor][1]}" for sensor in export.request.sensors}
    return {**{name: meaning for name, (_, meaning) in COLUMNS.items()}, **sensors}
