"""The format Minari: a dataset for each language, with the observations of the Gymnasium environment, lossless.

Minari stores images as JPEG by default; here they are stored without loss, in Arrow files compressed by Zstandard.
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

from arramon_client.environments.backend import SplitInfo
from arramon_client.environments.registration import NAMESPACE, register
from arramon_client.environments.spaces import NO_ACTION, Translator, action_space, observation_space
from arramon_client.environments.tokens import ByteTokenizer
from server.demonstrations.croissant import Records, write_croissant
from server.demonstrations.description import describe
from server.demonstrations.folder import Folder
from server.demonstrations.parts import Part
from server.demonstrations.rendering import Rendered, player_of, render, settings_of
from server.demonstrations.request import Export
from server.episodes.splits import Split

ENVIRONMENT = f"{NAMESPACE}/ArraMon-v0"

STORAGE = "arrow"

COMPRESSION = "zstd"


def dataset_id(export: Export, language: str) -> str:
    """Return the name of the dataset of a language, such as "arramon/train-en-v0"."""
    split = re.sub(r"[^-\w]", "_", export.request.split)
    return f"{NAMESPACE}/{split}-{language}-v0"


def write_part(export: Export, split: Split, part: Part, made: Path) -> Mapping[str, Any]:  # noqa: ARG001
    """Write a folder for each demonstration, by Minari itself."""
    numbers = dict(part.before)
    for source in part.sources:
        rendered = render(export, source)
        for language in source.languages:
            folder = made / dataset_id(export, language) / "data"
            _write_episode(export, rendered, language, numbers[language], folder)
            numbers[language] += 1
    return {"end": numbers, "steps": {language: _steps(part, language) for language in numbers}}


def finish(export: Export, split: Split, folder: Folder, parts: Sequence[Mapping[str, Any]]) -> None:  # noqa: ARG001
    """Write what describes the datasets, and the Croissant file."""
    languages = [language for language in export.request.languages if parts[-1]["end"][language]]
    for language in languages:
        name = dataset_id(export, language)
        made = folder.scratch("minari")
        storage = _new_storage(export, language, made)
        sizes = [path.stat().st_size for path in (folder.path / name).rglob("*") if path.is_file()]
        storage.update_metadata(
            {
                "dataset_id": name,
                "minari_version": minari.__version__,
                "total_episodes": parts[-1]["end"][language],
                "total_steps": sum(part["steps"][language] for part in parts),
                "dataset_size": round(sum(sizes) / 1e6, 1),
                "algorithm_name": "ground truth" if export.request.run_id is None else f"run {export.request.run_id}",
                "description": describe(export),
                "requirements": ["arramon-client[environments]", "arramon-server"],
            }
        )
        folder.place(made / METADATA_FILE_NAME, f"{name}/data/{METADATA_FILE_NAME}")
    sets = [
        Records(language, f"{dataset_id(export, language)}/data/*/*.arrow", "application/vnd.apache.arrow.file")
        for language in languages
    ]
    write_croissant(export, folder, sets)


def _steps(part: Part, language: str) -> int:
    return sum(len(source.actions) for source in part.sources if language in source.languages)


def _write_episode(export: Export, rendered: Rendered, language: str, number: int, folder: Path) -> None:
    """Write an episode as `number` of a dataset: by Minari to a folder of its own, then compressed to its place."""
    own = folder.parent / "own"
    storage = _new_storage(export, language, own)
    storage.update_episodes(
        [
            EpisodeBuffer(
                id=number,
                observations=_observations(_split_info(export, language), rendered, language),
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


def _observations(info: SplitInfo, rendered: Rendered, language: str) -> dict[str, Any]:
    """Return the environment's observations by key, one more than there are actions."""
    translator = Translator(_tokenizer(info, language))
    last = [NO_ACTION, *rendered.source.actions]
    values = [translator.observation(each, action) for each, action in zip(rendered.observations, last, strict=True)]
    texts = rendered.instructions(language, rendered.observations)
    columns: dict[str, Any] = {
        key: np.stack([value[key] for value in values]) for key in values[0] if key != "instruction"
    }
    columns["instruction_tokens"] = np.stack([translator.tokens(text) for text in texts])
    return {key: texts if key == "instruction" else columns[key] for key in values[0]}


def _new_storage(export: Export, language: str, folder: Path) -> Any:
    """Return a new storage of Minari, which the environment can be made from again."""
    register()
    request = export.request
    info = _split_info(export, language)
    folder.parent.mkdir(parents=True, exist_ok=True)
    spec = copy.deepcopy(gymnasium.spec(ENVIRONMENT))
    spec.kwargs = {
        "lang": language,
        "split": request.split,
        "sensors": list(request.sensors),
        "image_size": request.size,
        "reward": request.reward,
        "steps_per_phase": export.steps_per_phase,
    }
    return MinariStorage.new(
        folder,
        observation_space=observation_space(settings_of(export, language), info, _tokenizer(info, language)),
        action_space=action_space(),
        env_spec=spec,
        data_format=STORAGE,
        jpeg_encoding=False,
    )


def _split_info(export: Export, language: str) -> SplitInfo:
    return player_of(export, language).split


def _tokenizer(info: SplitInfo, language: str) -> ByteTokenizer:
    return ByteTokenizer(info.texts[language].longest_utf8)


def _compress(file: Path, target: Path) -> None:
    """Write an Arrow file again, compressed, as one batch: Minari takes a batch for an episode."""
    with pa.memory_map(str(file)) as mapped:
        (batch,) = pa.ipc.open_file(mapped).read_all().combine_chunks().to_batches()
        options = pa.ipc.IpcWriteOptions(compression=COMPRESSION)
        with target.open("wb") as out, pa.ipc.new_file(out, batch.schema, options=options) as writer:
            writer.write_batch(batch)
    file.unlink()
