"""Exports of the tiny split, and the expected observations from the simulator itself."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from arramon_dataset.demonstrations.export import ExportProgress, complete_request, export_demonstrations
from arramon_dataset.demonstrations.request import ResolvedExport, make_request
from arramon_dataset.demonstrations.sources import ground_truth
from arramon_server.episodes.splits import read_named_split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Limits
from arramon_server.sim.view import visible_pose
from tests import tiny

SIZE = 32

SENSORS = ("rgb", "depth", "segmentation", "pose")


def export(
    data: Path,
    output: Path,
    format_: str,
    *,
    split: str = "tiny",
    jobs: int = 1,
    on_progress: Callable[[ExportProgress], None] = lambda _: None,
    **more: Any,
) -> ResolvedExport:
    """Export ground truth; with all sensors and in parts of two episodes, unless other settings are given."""
    frames = {} if format_ == "plain" else {"sensors": SENSORS, "size": SIZE}
    found = read_named_split(data, split)
    request = complete_request(make_request(data, split, format_, **{"part_size": 2, **frames, **more}), found)
    return export_demonstrations(
        request, found, ground_truth(found, request), output, jobs=jobs, on_progress=on_progress
    )


@dataclass(frozen=True)
class ExpectedObservation:
    """The expected observation before an action."""

    turn: int
    phase: str
    steps_left: int
    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.float32]
    segmentation: npt.NDArray[np.uint16]
    pose: tuple[float, float, float]
    instruction: str


def expected_observations(
    data: Path, episode_id: str, language: str, actions: Sequence[int] = tiny.ACTIONS, size: int = SIZE
) -> Iterator[ExpectedObservation]:
    """Yield the observations before each action, made by the rules and the camera without the environments."""
    split = read_named_split(data, "tiny")
    episode = split.episodes[episode_id]
    with closing(Worlds({"tiny": split})) as worlds:
        world = worlds.world("tiny", episode)
        session = EpisodeSession(episode, world, Limits())
        for state, _ in session.replay(actions):
            frame = world.render(state, size, segmentation=True)
            assert frame.segmentation is not None
            pose = visible_pose(state)
            yield ExpectedObservation(
                state.turn,
                state.phase.value,
                session.steps_left(state),
                frame.rgb.copy(),
                frame.depth.astype(np.float32) * np.float32(0.001),
                frame.segmentation.copy(),
                (pose.x, pose.z, pose.heading),
                episode.instruction(language, state.turn, state.phase.value),
            )


def playing_order(data: Path, language: str) -> list[str]:
    """Ids of the episodes in a language, as they are exported."""
    return [episode.episode_id for episode in read_named_split(data, "tiny").in_playing_order(language)]


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder, by path."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
