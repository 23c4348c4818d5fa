"""Demonstrations of the expert, as visual features and actions, rendered once and cached on disk.

Images are not stored: rendering a frame is faster than reading a JPEG. The cache has one file per episode, so an
interrupted collection resumes where it stopped.
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
import zstandard

from arramon_agents.perception.encoder import GRID, VisualEncoder, quantise
from arramon_agents.perception.registry import open_encoder
from arramon_client.agent import Observation
from arramon_client.environments.backend import Backend, Player, PlayerSettings
from arramon_client.environments.options import Options
from arramon_client.environments.players import open_backend
from arramon_client.world import ASSEMBLY, NAVIGATION, PHASES
from arramon_dataset.parallel import process_pool

ROOMS = "drawn_rooms"
"""Name of the split of generated tasks in the assembly room only."""

ROOM_PREFIX = "room-"
"""Prefix of episode ids of the split ROOMS."""

EXPERT = "reference"
"""Name of the expert that is imitated."""


@dataclass(frozen=True)
class PhaseDemonstration:
    """One phase played by the expert.

    Attributes:
        episode_id, turn, phase: episode, turn and name of the phase.
        texts: instruction by language.
        actions: actions of the expert, (S,) uint8.
        features: quantised visual features before each action, (S, 7, 7, C) uint8.
    """

    episode_id: str
    turn: int
    phase: str
    texts: dict[str, str]
    actions: npt.NDArray[np.uint8]
    features: npt.NDArray[np.uint8]

    def texts_in(self, languages: Sequence[str]) -> list[str]:
        """Return the instructions in those of the languages that it has."""
        return [self.texts[language] for language in languages if language in self.texts]


@dataclass(frozen=True)
class DemonstrationSource:
    """Episodes to demonstrate, and the visual encoder of their features.

    Attributes:
        data: data folder.
        split: name of the split, or ROOMS.
        languages: languages of the instructions. Every episode must have the first; the others are optional.
        encoder: name of the visual encoder; empty for no images, with C = 0.
        episodes: number of episodes, in playing order; 0 for all. For ROOMS, number of seeds from `first` on.
        first: first seed of ROOMS.
        every: take every n-th episode in playing order, from the n-th on; 1 for all. `episodes` counts the remaining
            ones. No effect on ROOMS.
    """

    data: Path
    split: str
    languages: tuple[str, ...]
    encoder: str
    episodes: int
    first: int = 0
    every: int = 1


def collect(source: DemonstrationSource, cache: Path, processes: int = 1) -> Iterator[Sequence[PhaseDemonstration]]:
    """Yield the demonstrations of each episode, rendering those that are not cached.

    Args:
        source: the episodes.
        cache: folder of the cache.
        processes: number of rendering processes.

    Raises:
        UsageError: if the data folder does not have the split or a language.
    """
    encoder = _encoder(source)
    ids, data_hash = episodes_of(source)
    eyes = f"{encoder.name}/{encoder.fingerprint}" if encoder else ""
    key = f"{data_hash}/{'+'.join(source.languages)}/{eyes}/{_VERSION}"
    folder = cache / f"{source.split}-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{episode_id}.zst" for episode_id in ids]
    missing = [(episode_id, path) for episode_id, path in zip(ids, paths, strict=True) if not path.exists()]
    several = process_pool(processes, "renders demonstrations") if processes > 1 and missing else nullcontext()
    with several as pool:
        render = partial(_render, source)
        drawn = (pool.map if pool else map)(render, *zip(*missing, strict=True)) if missing else iter(())
        for path in paths:
            while not path.exists():
                next(drawn)
            yield read_demonstrations(path)


def read_demonstrations(path: Path) -> list[PhaseDemonstration]:
    """Return the demonstrations of an episode from its file in the cache."""
    raw = zstandard.ZstdDecompressor().decompress(path.read_bytes())
    length = int.from_bytes(raw[:8])
    found, at = [], 8 + length
    for item in json.loads(raw[8:at]):
        steps, channels = item["steps"], item["channels"]
        size = steps * GRID * GRID * channels
        actions = np.frombuffer(raw, np.uint8, steps, at)
        features = np.frombuffer(raw, np.uint8, size, at + steps).reshape(steps, GRID, GRID, channels)
        found.append(
            PhaseDemonstration(item["episode_id"], item["turn"], item["phase"], item["texts"], actions, features)
        )
        at += steps + size
    return found


def without_features(demonstration: PhaseDemonstration) -> PhaseDemonstration:
    """Return a demonstration with 0 feature channels, (S, 7, 7, 0)."""
    return replace(demonstration, features=np.zeros((len(demonstration.actions), GRID, GRID, 0), np.uint8))


def write_demonstrations(path: Path, demonstrations: Sequence[PhaseDemonstration]) -> None:
    """Write the demonstrations of an episode to its file in the cache, atomically."""
    items = [
        {
            "episode_id": each.episode_id,
            "turn": each.turn,
            "phase": each.phase,
            "texts": each.texts,
            "steps": len(each.actions),
            "channels": each.features.shape[-1],
        }
        for each in demonstrations
    ]
    header = json.dumps(items, ensure_ascii=False).encode()
    arrays = b"".join(each.actions.tobytes() + each.features.tobytes() for each in demonstrations)
    temporary = path.with_suffix(".part")
    temporary.write_bytes(zstandard.ZstdCompressor(3).compress(len(header).to_bytes(8) + header + arrays))
    temporary.replace(path)


_VERSION = 1


def data_hash_of(source: DemonstrationSource) -> str:
    """Return the hash of a source's data.

    Raises:
        UsageError: if the data folder does not have the split or a language.
    """
    return episodes_of(source)[1]


def episodes_of(source: DemonstrationSource) -> tuple[list[str], str]:
    """Return the ids of the episodes of a source, and the hash of their data.

    Raises:
        UsageError: if the data folder does not have the split or a language.
    """
    player = backend_of(source).player(settings_of(source, source.languages[0]))
    info = player.split
    if source.split == ROOMS:
        return [f"{ROOM_PREFIX}{seed}" for seed in range(source.first, source.first + source.episodes)], "drawn"
    ids = list(info.episode_ids or ())[source.every - 1 :: source.every]
    return ids[: source.episodes or None], info.data_hash


def _encoder(source: DemonstrationSource) -> VisualEncoder | None:
    return open_encoder(source.encoder) if source.encoder else None


def backend_of(source: DemonstrationSource) -> Backend:
    """Return the environment backend for the episodes of a source."""
    return open_backend(Options(data=source.data))


def settings_of(
    source: DemonstrationSource, language: str, size: int = 0, phases: tuple[str, ...] = PHASES
) -> PlayerSettings:
    """Return the player's settings for a source; `size` is the side length of images, 0 for no images."""
    if source.split == ROOMS:
        phases = (ASSEMBLY,)
    return PlayerSettings(
        language=language,
        split=source.split,
        sensors=("rgb", "depth") if size else (),
        image_size=size or 8,
        expert=EXPERT,
        phases=phases,
        start=ASSEMBLY if source.split == ROOMS else NAVIGATION,
    )


@dataclass(frozen=True)
class _Renderer:
    """State of a rendering process: visual encoder, a player with images, a player without for each other language."""

    encoder: VisualEncoder | None
    player: Player
    others: dict[str, Player]


@lru_cache(maxsize=1)
def _renderer(source: DemonstrationSource) -> _Renderer:
    backend, encoder = backend_of(source), _encoder(source)
    first, *others = source.languages
    player = backend.player(settings_of(source, first, encoder.image_size if encoder else 0))
    return _Renderer(encoder, player, {language: backend.player(settings_of(source, language)) for language in others})


def _render(source: DemonstrationSource, episode_id: str, path: Path) -> None:
    """Render an episode, and write it to the cache."""
    easel = _renderer(source)
    drawn = _play_expert(easel.player, episode_id, source.languages[0], easel.encoder)
    for language, other in easel.others.items():
        if other.split.episode_ids is None or episode_id in other.split.episode_ids:
            _add_texts(drawn, other, language)
    write_demonstrations(path, drawn)


def _play_expert(
    player: Player, episode_id: str, language: str, encoder: VisualEncoder | None
) -> list[PhaseDemonstration]:
    """Let the expert play an episode, and return its phases."""
    phases: dict[tuple[int, str], list[tuple[Observation, int]]] = {}
    observation: Observation | None = player.begin(episode_id, 0)
    while observation is not None:
        action = player.expert_action()
        phases.setdefault((observation.turn, observation.phase), []).append((observation, action))
        observation = player.step(action).observation
    found = []
    for (turn, phase), steps in phases.items():
        features = np.zeros((len(steps), GRID, GRID, 0), np.uint8)
        if encoder is not None:
            rgb = np.stack([np.asarray(observation.rgb) for observation, _ in steps])
            depth = np.stack([np.asarray(observation.depth) for observation, _ in steps])
            features = quantise(encoder.encode(rgb, depth))
        actions = np.array([action for _, action in steps], np.uint8)
        texts = {language: steps[0][0].instruction}
        found.append(PhaseDemonstration(episode_id, turn, phase, texts, actions, features))
    return found


def _add_texts(played: Sequence[PhaseDemonstration], player: Player, language: str) -> None:
    """Add the instructions in another language if they describe the same task: the same actions in every phase."""
    texts: dict[tuple[int, str], str] = {}
    actions: dict[tuple[int, str], list[int]] = {}
    observation: Observation | None = player.begin(played[0].episode_id, 0)
    while observation is not None:
        phase = observation.turn, observation.phase
        texts[phase] = observation.instruction
        actions.setdefault(phase, []).append(action := player.expert_action())
        observation = player.step(action).observation
    if all(actions.get((each.turn, each.phase)) == each.actions.tolist() for each in played):
        for each in played:
            each.texts[language] = texts[each.turn, each.phase]
