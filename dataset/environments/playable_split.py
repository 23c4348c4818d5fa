"""Splits with the worlds in which they are played, cached for the players of each thread."""

import threading
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from arramon_server.episodes.splits import Split, no_splits_error, read_split, split_folder, split_folders
from arramon_server.errors import NotFound
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.footprints import Footprints

CACHED_SPLITS = 16
"""Maximum number of cached splits over all threads."""

DRAWN = "drawn_rooms"
"""Name of the split of room tasks that are generated as they are played."""


@dataclass(frozen=True, eq=False)
class PlayableSplit:
    """A split with the worlds in which it is played, for use by one thread."""

    split: Split
    worlds: Worlds


def playable_split(split: Split, camera: str) -> PlayableSplit:
    """Return a split with its worlds. Plane geometry checks collisions, as it starts faster than pybullet."""
    return PlayableSplit(split, Worlds({split.name: split}, camera, Footprints))


def open_playable_split(data: Path, name: str, camera: str) -> PlayableSplit:
    """Return a split of a data folder with its worlds, shared by all callers in this thread.

    Args:
        data: the data folder.
        name: of the split.
        camera: name of the camera, one of `arramon_server.sim.cameras.CAMERAS`.

    Raises:
        NotFound: if there is no such split; the message lists the existing ones, or says how to generate one.
        BadFile: if a file of the split is invalid.
    """
    folders = {folder.name: folder for folder in split_folders(data)}
    if not folders:
        raise no_splits_error(data)
    if name not in folders:
        raise NotFound(f"there is no split {name!r} in {data}; there are {', '.join(folders)}")
    folder = split_folder(data, name)
    changed = (folder / "episodes.jsonl").stat().st_mtime_ns
    return _open(folder.absolute(), changed, camera, threading.get_ident())


@lru_cache(CACHED_SPLITS)
def _open(folder: Path, changed: int, camera: str, thread: int) -> PlayableSplit:  # noqa: ARG001 - parts of the key
    return playable_split(read_split(folder), camera)
