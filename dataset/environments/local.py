"""The in-process backend of environments: splits of a data folder, and room tasks generated on demand."""

import os
from collections.abc import Sequence
from pathlib import Path

from arramon_client.environments.backend import PlayerSettings, SplitInfo, TextBounds
from arramon_client.errors import UsageError
from arramon_client.world import STEPS_PER_PHASE
from arramon_dataset.environments.playable_split import DRAWN, PlayableSplit, open_playable_split
from arramon_dataset.environments.player import LocalPlayer
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.instruction_texts import instructions_in
from arramon_server.episodes.splits import Split
from arramon_server.errors import ArraMonError
from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.physics import problem_of_camera
from arramon_server.sim.raster.camera import compile_kernels

CAMERA = "ARRAMON_CAMERA"
"""Environment variable that selects the camera, as for the server."""


class LocalBackend:
    """Opens in-process players.

    Args:
        data: the data folder; splits are read when they are first played.

    Raises:
        UsageError: if the environment variable ARRAMON_CAMERA names no camera, or one that is not installed.
    """

    def __init__(self, data: Path) -> None:
        self._data = data
        self._camera = os.environ.get(CAMERA) or CAMERAS[0]
        problem = problem_of_camera(self._camera)
        if problem:
            raise UsageError(f"{CAMERA} is {self._camera!r}, {problem}")

    def player(self, settings: PlayerSettings) -> LocalPlayer:
        """Return a player.

        Raises:
            UsageError: if there is no such split, or the split lacks the language or a sensor, or forbids the reward.
        """
        if settings.split == DRAWN:
            # Imported only here, as generating tasks needs the languages and the instruction planners.
            from arramon_dataset.environments.random_rooms import draw_room, playable_rooms, room_split

            info = room_split(settings)
            library = playable_rooms(self._camera)
            return LocalPlayer(library, info, settings, lambda id_, seed: draw_room(seed, settings.language, id_))
        library = self._library(settings.split)
        split = library.split
        info = _info(split, settings.language, settings.steps_per_phase)

        def find(episode_id: str | None, seed: int) -> Episode:  # noqa: ARG001 - drawn tasks have seeds
            return _find(split, episode_id)

        return LocalPlayer(library, info, settings, find)

    def instructions(self, split: str, language: str) -> list[str]:
        """Return all instruction texts of a split in a language, in order.

        Raises:
            UsageError: if there is no such split, or it lacks the language.
        """
        found = self._library(split).split
        _check_language(found, language)
        return instructions_in(found.episodes.values(), language)

    def prepare(self) -> None:
        """Compile the camera before worker processes start, so that they need not."""
        if self._camera == CAMERAS[0]:
            compile_kernels()

    def _library(self, name: str) -> PlayableSplit:
        try:
            return open_playable_split(self._data, name, self._camera)
        except ArraMonError as error:
            raise UsageError(str(error)) from error


def _info(split: Split, language: str, steps_per_phase: int | None) -> SplitInfo:
    _check_language(split, language)
    return SplitInfo(
        name=split.name,
        hidden=split.hidden,
        sensors=tuple(name for name in split.sensors if name != "oracle"),
        steps_per_phase=steps_per_phase or STEPS_PER_PHASE,
        data_hash=split.data_hash,
        texts={
            code: TextBounds(texts.alphabet, texts.longest, texts.longest_utf8) for code, texts in split.texts.items()
        },
        episode_ids=_ids(split, language),
    )


def _ids(split: Split, language: str) -> Sequence[str]:
    return [episode.episode_id for episode in split.in_playing_order(language)]


def _check_language(split: Split, language: str) -> None:
    if language not in split.languages:
        there = ", ".join(split.languages)
        raise UsageError(f"the split {split.name!r} has no language {language!r}; it has {there}")


def _find(split: Split, episode_id: str | None) -> Episode:
    if episode_id is None or episode_id not in split.episodes:
        raise UsageError(f"there is no episode {episode_id!r} in the split {split.name!r}")
    return split.episodes[episode_id]
