"""The Minari format: one dataset for each language or for all, with the environment's observations.

Minari stores images as JPEG by default; here they are stored losslessly, in Arrow files compressed by Zstandard.
"""

import copy
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import minari
import numpy as np
import pyarrow as pa
from minari.data_collector.episode_buffer import EpisodeBuffer
from minari.dataset.minari_storage import METADATA_FILE_NAME, MinariStorage

from arramon_client.environments.backend import TextBounds
from arramon_client.environments.registration import NAMESPACE, register
from arramon_client.environments.spaces import (
    NO_ACTION,
    ObservationConverter,
    action_space,
    merge_bounds,
    observation_space,
)
from arramon_client.environments.tokens import ByteTokenizer
from arramon_dataset.demonstrations.croissant import CroissantFiles, write_croissant
from arramon_dataset.demonstrations.description import describe_export
from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.rendering import RenderedDemonstration, player_of, render, settings_of
from arramon_dataset.demonstrations.request import ResolvedExport
from arramon_server.episodes.splits import Split

ENVIRONMENT = f"{NAMESPACE}/ArraMon-v0"

STORAGE = "arrow"

COMPRESSION = "zstd"


def datasets_of(export: ResolvedExport) -> list[tuple[str, ...]]:
    """Return the languages of each dataset."""
    languages = export.request.languages
    return [languages] if export.request.single_dataset else [(language,) for language in languages]


def dataset_id(export: ResolvedExport, languages: Sequence[str]) -> str:
    """Return the id of the dataset of some languages, like "arramon/train-en-v0" or "arramon/train-en_hi-v0"."""
    split = re.sub(r"[^-\w]", "_", export.request.split)
    return f"{NAMESPACE}/{split}-{'_'.join(languages)}-v0"


def write_part(export: ResolvedExport, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:  # noqa: ARG001
    """Write a folder for each demonstration with the library `minari`."""
    groups = datasets_of(export)
    numbers = [sum(part.before[language] for language in languages) for languages in groups]
    ends = dict(part.before)
    for source in part.sources:
        rendered = render(export, source)
        for group, languages in enumerate(groups):
            folder = made / dataset_id(export, languages) / "data"
            for language in (each for each in source.languages if each in languages):
                _write_episode(export, rendered, language, languages, numbers[group], folder)
                numbers[group] += 1
                ends[language] += 1
    return {"end": ends, "steps": {language: _steps(part, language) for language in ends}}


def finish(export: ResolvedExport, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]) -> None:  # noqa: ARG001
    """Write the metadata of the datasets, and the Croissant file."""
    ends = parts[-1]["end"]
    groups = [languages for languages in datasets_of(export) if any(ends[language] for language in languages)]
    for languages in groups:
        name = dataset_id(export, languages)
        made = folder.scratch("minari")
        storage = _new_storage(export, languages, made)
        sizes = [path.stat().st_size for path in (folder.path / name).rglob("*") if path.is_file()]
        storage.update_metadata(
            {
                "dataset_id": name,
                "minari_version": minari.__version__,
                "total_episodes": sum(ends[language] for language in languages),
                "total_steps": sum(part["steps"][language] for part in parts for language in languages),
                "dataset_size": round(sum(sizes) / 1e6, 1),
                "algorithm_name": "ground truth" if export.request.run_id is None else f"run {export.request.run_id}",
                "description": describe_export(export),
                "requirements": ["arramon-client[environments]", "arramon-server"],
            }
        )
        folder.place(made / METADATA_FILE_NAME, f"{name}/data/{METADATA_FILE_NAME}")
    sets = [
        CroissantFiles(
            "_".join(each), f"{dataset_id(export, each)}/data/*/*.arrow", "application/vnd.apache.arrow.file"
        )
        for each in groups
    ]
    write_croissant(export, folder, sets)


def _steps(part: ExportPart, language: str) -> int:
    return sum(len(source.actions) for source in part.sources if language in source.languages)


def _write_episode(
    export: ResolvedExport,
    rendered: RenderedDemonstration,
    language: str,
    languages: Sequence[str],
    number: int,
    folder: Path,
) -> None:
    """Write an episode as `number` of a dataset: with `minari` to a separate folder, then compressed to its place."""
    own = folder.parent / "own"
    storage = _new_storage(export, languages, own)
    storage.update_episodes(
        [
            EpisodeBuffer(
                id=number,
                observations=_observations(_tokenizer(_texts(export, languages)), rendered, language),
                actions=np.asarray(rendered.source.actions, np.int64),
                rewards=list(rendered.rewards),
                terminations=rendered.terminated(),
                truncations=rendered.truncated(),
            )
        ]
    )
    words = {"episode_id": rendered.source.episode_id, "language": language, "cause": rendered.source.cause}
    storage.update_episode_metadata([{**words, "scores": rendered.scores}], [number])
    target = folder / str(number)
    target.mkdir(parents=True)
    for file in (own / str(number)).iterdir():
        if file.suffix == f".{STORAGE}":
            _compress(file, target / file.name)
        else:
            file.rename(target / file.name)
    shutil.rmtree(own)


def _observations(tokenizer: ByteTokenizer, rendered: RenderedDemonstration, language: str) -> dict[str, Any]:
    """Return the environment's observations by key; there is one more than there are actions."""
    translator = ObservationConverter(tokenizer)
    last = [NO_ACTION, *rendered.source.actions]
    values = [translator.observation(each, action) for each, action in zip(rendered.observations, last, strict=True)]
    texts = rendered.instructions(language, rendered.observations)
    columns: dict[str, Any] = {
        key: np.stack([value[key] for value in values]) for key in values[0] if key != "instruction"
    }
    columns["instruction_tokens"] = np.stack([translator.tokens(text) for text in texts])
    return {key: texts if key == "instruction" else columns[key] for key in values[0]}


def _new_storage(export: ResolvedExport, languages: Sequence[str], folder: Path) -> Any:
    """Return a new Minari storage, with the specification to recreate the environment."""
    register()
    request = export.request
    texts = _texts(export, languages)
    folder.parent.mkdir(parents=True, exist_ok=True)
    spec = copy.deepcopy(gymnasium.spec(ENVIRONMENT))
    spec.kwargs = {
        "lang": languages[0] if len(languages) == 1 else list(languages),
        "split": request.split,
        "sensors": list(request.sensors),
        "image_size": request.size,
        "reward": request.reward,
        "steps_per_phase": export.steps_per_phase,
    }
    settings = settings_of(export, languages[0])
    return MinariStorage.new(
        folder.absolute(),  # Minari would resolve a relative path twice.
        observation_space=observation_space(settings, texts, export.steps_per_phase, _tokenizer(texts)),
        action_space=action_space(),
        env_spec=spec,
        data_format=STORAGE,
        jpeg_encoding=False,
    )


def _texts(export: ResolvedExport, languages: Sequence[str]) -> TextBounds:
    """Return alphabet and maximum lengths of the instructions in all languages of a dataset."""
    return merge_bounds(player_of(export, language).split.texts[language] for language in languages)


def _tokenizer(texts: TextBounds) -> ByteTokenizer:
    return ByteTokenizer(texts.longest_utf8)


def _compress(file: Path, target: Path) -> None:
    """Rewrite an Arrow file, compressed, as one record batch: Minari reads each batch as an episode."""
    with pa.memory_map(str(file)) as mapped:
        (batch,) = pa.ipc.open_file(mapped).read_all().combine_chunks().to_batches()
        options = pa.ipc.IpcWriteOptions(compression=COMPRESSION)
        with target.open("wb") as out, pa.ipc.new_file(out, batch.schema, options=options) as writer:
            writer.write_batch(batch)
    file.unlink()
