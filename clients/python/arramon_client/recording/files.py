"""Files of one recorded episode: frames, steps as JSON Lines, and a description."""

import hashlib
import re
import shutil
import struct
import zlib
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import numpy.typing as npt
import simplejpeg

from arramon_client.agent import Episode, Observation
from arramon_client.files import write_whole
from arramon_client.printable import to_json, to_json_line
from arramon_client.recording.trace import Trace

FORMAT, VERSION = "arramon-recording", 1

ABOUT, STEPS, PAGE = "episode.json", "steps.jsonl", "index.html"
"""Names of the files in an episode's folder; images are in the subfolders `rgb` and `depth`."""

JPEG_QUALITY = 90


class EpisodeFiles:
    """Writer of one episode's files while it is played.

    Args:
        folder: the episode's folder; the files of an earlier attempt are removed.
        episode: the episode as passed to the agent.

    Raises:
        OSError: also in every method, if a file cannot be written.
    """

    def __init__(self, folder: Path, episode: Episode) -> None:
        self.folder = folder
        self._trace = Trace()
        if episode.oracle is not None:
            start = episode.oracle.start
            self._trace.street = (start.x, start.z, start.heading)
        if folder.exists():
            shutil.rmtree(folder)
        folder.mkdir(parents=True)
        self._steps: TextIO = (folder / STEPS).open("w", encoding="utf-8")
        self._about: dict[str, Any] = {
            "format": FORMAT,
            "version": VERSION,
            "episode_id": episode.episode_id,
            "language": episode.language,
            "split": episode.split,
            "cause": "",
            "steps": 0,
            "pictures_left_out": 0,
            "poses": self._trace.source,
            **_oracle(episode),
        }

    def step(self, observation: Observation, action: int | None, *, left_out: bool) -> None:
        """Write an observation and its action.

        Args:
            observation: the observation; without images if `left_out`.
            action: the action taken; None if the agent failed.
            left_out: whether images were left out.
        """
        name = f"{observation.step:04d}"
        pictures: dict[str, str] = {}
        if observation.rgb is not None:
            pictures["rgb"] = f"rgb/{name}.jpg"
            self._write(pictures["rgb"], _jpeg(observation.rgb))
        if observation.depth is not None:
            pictures["depth"] = f"depth/{name}.png"
            self._write(pictures["depth"], depth_png(observation.depth))
        pose = self._trace.at(observation)
        line = {
            "step": observation.step,
            "turn": observation.turn,
            "phase": observation.phase,
            "phase_step": observation.phase_step,
            "steps_left": observation.steps_left,
            "instruction": observation.instruction,
            "action": action,
            "pose": [round(number, 6) for number in pose],
            **pictures,
        }
        self._steps.write(to_json_line(line))
        if action is not None:
            self._trace.move(observation, action)
        self._about["steps"] += action is not None
        self._about["pictures_left_out"] += left_out
        self._about["poses"] = self._trace.source

    def _write(self, name: str, content: bytes) -> None:
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)

    def end(self, cause: str) -> None:
        """Close the files.

        Args:
            cause: why the episode ended; empty if it has not ended.
        """
        self._steps.close()
        self._about["cause"] = cause
        write_whole(self.folder / ABOUT, to_json(self._about))

    def abandon(self) -> None:
        """Close the open file, ignoring errors."""
        try:
            self._steps.close()
        except OSError:  # Buffered lines cannot be written; the participant has been notified.
            return


def folder_name(episode_id: str) -> str:
    """Return a unique folder name for an episode id, without characters that a file system may not allow."""
    plain = re.sub(r"[^A-Za-z0-9._-]", "_", episode_id)[:80].lstrip(".")
    if plain == episode_id and plain:
        return plain
    return f"{plain or '_'}-{hashlib.sha256(episode_id.encode()).hexdigest()[:8]}"


def depth_png(depth: npt.NDArray[np.float32]) -> bytes:
    """Encode a depth map losslessly as a 16-bit greyscale PNG in thousandths of a unit, the protocol's resolution."""
    thousandths = np.clip(np.rint(depth * np.float32(1000.0)), 0, 65535).astype(">u2")
    height, width = thousandths.shape
    rows = thousandths.view(np.uint8).reshape(height, 2 * width)
    lines = np.full((height, 1 + 2 * width), 2, np.uint8)  # PNG filter 2: the difference from the row above.
    lines[:, 1:] = np.diff(rows, axis=0, prepend=np.zeros((1, 2 * width), np.uint8))
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _jpeg(rgb: npt.NDArray[np.uint8]) -> bytes:
    encoded: bytes = simplejpeg.encode_jpeg(np.ascontiguousarray(rgb), quality=JPEG_QUALITY, colorspace="RGB")
    return encoded


def _oracle(episode: Episode) -> dict[str, Any]:
    """Return the oracle's map: obstacles as [x, z, half width, half length, heading], and targets as [x, z]."""
    oracle = episode.oracle
    if oracle is None:
        return {}
    return {
        "obstacles": [
            [round(number, 3) for number in (each.x, each.z, each.half_width, each.half_length, each.heading)]
            for each in oracle.obstacles
        ],
        "targets": [[round(each.position.x, 3), round(each.position.z, 3)] for each in oracle.targets],
    }
