"""`arramon-server stats`: which splits and languages are measured, and what comes of it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from server.episodes.episode import Episode, languages_of
from server.episodes.files import read_episodes
from server.episodes.splits import folder_of, folders_of
from server.errors import BadInput, NotFound
from server.stats.diversity import SAMPLE
from server.stats.measure import Figures, measure


def figures_of(
    data: Path, splits: Sequence[str] = (), languages: Sequence[str] = (), *, sample: int = SAMPLE, seed: int = 0
) -> list[Figures]:
    """Measures the splits of a data folder in each language, and all of them on samples of equal size.

    Args:
        data: the data folder.
        splits: by name; none for all that there are.
        languages: codes; none for all that a split has.
        sample: instructions of a phase to draw at most for the diversity; fewer where a split has fewer.
        seed: of that draw.

    Raises:
        BadFile: if a file is wrong.
        BadInput: if the sample is too small.
        NotFound: if there is no such split, or none with such a language.
    """
    if sample < 2:
        raise BadInput(f"a sample of {sample} instructions was asked for, expected 2 or more")
    chosen = _chosen(_read(data, splits), languages)
    size = min(sample, *(2 * len(episodes) for _, _, episodes in chosen))
    return [measure(split, episodes, code, sample=size, seed=seed) for split, code, episodes in chosen]


def as_json(columns: Sequence[Figures]) -> list[dict[str, Any]]:
    """The figures as JSON has them: an object for each split and language."""
    return [asdict(each) for each in columns]


def _read(data: Path, names: Sequence[str]) -> dict[str, list[Episode]]:
    there = [folder.name for folder in folders_of(data)]
    if not there:
        raise NotFound(f"there are no episodes in {data}")
    for name in names:
        if name not in there:
            raise NotFound(f"there is no split {name!r} in {data}; there are {', '.join(there)}")
    return {name: read_episodes(folder_of(data, name) / "episodes.jsonl")[1] for name in dict.fromkeys(names or there)}


def _chosen(splits: Mapping[str, Sequence[Episode]], languages: Sequence[str]) -> list[tuple[str, str, list[Episode]]]:
    """Split, language and the episodes that hold it."""
    spoken = {name: languages_of(episodes) for name, episodes in splits.items()}
    for code in languages:
        if not any(code in codes for codes in spoken.values()):
            known = ", ".join(sorted({known for codes in spoken.values() for known in codes}))
            raise NotFound(f"there is no {code!r} in {', '.join(splits)}; there are {known}")
    return [
        (name, code, [episode for episode in episodes if code in episode.instructions])
        for name, episodes in splits.items()
        for code in spoken[name]
        if not languages or code in languages
    ]
