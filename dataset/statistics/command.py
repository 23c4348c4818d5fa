"""Measurement of selected splits and languages, for `arramon-server stats`."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from arramon_dataset.statistics.diversity import SAMPLE
from arramon_dataset.statistics.measure import SplitStatistics, measure
from arramon_server.episodes.episode import Episode, languages_of
from arramon_server.episodes.split_files import read_episodes
from arramon_server.episodes.splits import split_folder, split_folders
from arramon_server.errors import BadInput, NotFound


def statistics_of(
    data: Path, splits: Sequence[str] = (), languages: Sequence[str] = (), *, sample: int = SAMPLE, seed: int = 0
) -> list[SplitStatistics]:
    """Measure splits of a data folder in each language, all on samples of equal size.

    Args:
        data: the data folder.
        splits: names; empty for all.
        languages: codes; empty for all languages of a split.
        sample: maximum number of instructions of a phase sampled for the diversity; limited by the smallest split.
        seed: of the sample.

    Raises:
        BadFile: if a file is invalid.
        BadInput: if the sample is too small.
        NotFound: if a split does not exist, or no split has the language.
    """
    if sample < 2:
        raise BadInput(f"the sample size is {sample}; expected at least 2")
    chosen = _select(_read(data, splits), languages)
    size = min(sample, *(2 * len(episodes) for _, _, episodes, _ in chosen))
    return [
        measure(split, episodes, code, lacking=lacking, sample=size, seed=seed)
        for split, code, episodes, lacking in chosen
    ]


def as_json(columns: Sequence[SplitStatistics]) -> list[dict[str, Any]]:
    """Return the statistics as JSON data: one object for each split and language."""
    return [asdict(each) for each in columns]


def _read(data: Path, names: Sequence[str]) -> dict[str, list[Episode]]:
    there = [folder.name for folder in split_folders(data)]
    if not there:
        raise NotFound(f"there are no episodes in {data}")
    for name in names:
        if name not in there:
            raise NotFound(f"there is no split {name!r} in {data}; there are {', '.join(there)}")
    return {
        name: read_episodes(split_folder(data, name) / "episodes.jsonl")[1] for name in dict.fromkeys(names or there)
    }


def _select(
    splits: Mapping[str, Sequence[Episode]], languages: Sequence[str]
) -> list[tuple[str, str, list[Episode], int]]:
    """Return (split, language, episodes in that language, number of those without) for all combinations to measure."""
    spoken = {name: languages_of(episodes) for name, episodes in splits.items()}
    for code in languages:
        if not any(code in codes for codes in spoken.values()):
            known = ", ".join(sorted({known for codes in spoken.values() for known in codes}))
            raise NotFound(f"there is no language {code!r} in {', '.join(splits)}; there are {known}")
    return [
        (
            name,
            code,
            [episode for episode in episodes if code in episode.instructions],
            len(episodes) - spoken[name][code],
        )
        for name, episodes in splits.items()
        for code in spoken[name]
        if not languages or code in languages
    ]
