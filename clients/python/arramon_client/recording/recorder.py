"""Recording of a run: observations and actions are queued, and a separate thread writes them to files."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from queue import SimpleQueue
from types import TracebackType
from typing import Protocol

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Episode, Observation
from arramon_client.errors import OutputError
from arramon_client.recording import page
from arramon_client.recording.files import EpisodeFiles, folder_name

MAX_QUEUED_BYTES = 256 * 1024 * 1024
"""Maximum size of images waiting to be written; further images are dropped, so that the run never waits for a disk."""


@dataclass(frozen=True)
class _BeginEntry:
    episode: Episode


@dataclass(frozen=True)
class _StepEntry:
    observation: Observation
    action: int | None
    left_out: bool
    waiting: int


@dataclass(frozen=True)
class _EndEntry:
    episode_id: str
    cause: str


_Entry = _BeginEntry | _StepEntry | _EndEntry | None


class EpisodeRecorder(Protocol):
    """Interface through which a session reports its episodes; `Recording` writes them to files."""

    def begin(self, episode: Episode) -> None:
        """Begin an episode, replacing an earlier recording of it."""

    def step(self, observation: Observation, action: int | None) -> None:
        """Record an observation and the agent's action; None if the agent failed."""

    def end(self, episode_id: str, cause: types_pb2.Cause.ValueType) -> None:
        """Record that an episode ended, and why."""


class Recording:
    """Recording of a run to a folder. Thread-safe; only `close` blocks.

    A write error ends the recording, not the run: the participant is notified once, and `error` is set.

    Args:
        folder: folder for recordings, in which the run gets a subfolder.
        run: the run that is played.
        notify: called with messages for the participant.

    Attributes:
        folder: the run's folder.
        error: the error that ended the recording; None if there was none.
    """

    def __init__(self, folder: Path, run: evaluation_pb2.Run, notify: Callable[[str], None]) -> None:
        self.folder = folder / folder_name(run.run_id)
        self.error: OutputError | None = None
        self._run = run
        self._notify = notify
        self._queue: SimpleQueue[_Entry] = SimpleQueue()
        self._waiting, self._lock = 0, threading.Lock()
        self._open: dict[str, EpisodeFiles] = {}
        self._thread = threading.Thread(target=self._write_all, name="recording", daemon=True)
        self._thread.start()

    def __enter__(self) -> "Recording":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    @property
    def index(self) -> Path:
        """The page that lists the episodes."""
        return self.folder / page.INDEX

    def begin(self, episode: Episode) -> None:
        """Begin an episode, replacing an earlier recording of it."""
        self._queue.put(_BeginEntry(episode))

    def step(self, observation: Observation, action: int | None) -> None:
        """Record an observation and the agent's action; None if the agent failed."""
        size = sum(image.nbytes for image in (observation.rgb, observation.depth) if image is not None)
        observation = replace(observation, segmentation=None)
        with self._lock:
            left_out = size > 0 and self._waiting + size > MAX_QUEUED_BYTES
            self._waiting += 0 if left_out else size
        if left_out:
            observation, size = replace(observation, rgb=None, depth=None), 0
        self._queue.put(_StepEntry(observation, action, left_out, size))

    def end(self, episode_id: str, cause: types_pb2.Cause.ValueType) -> None:
        """Record that an episode ended, and why."""
        name = types_pb2.Cause.Name(cause) if cause in types_pb2.Cause.values() else str(cause)
        self._queue.put(_EndEntry(episode_id, name.removeprefix("CAUSE_")))

    def close(self) -> None:
        """Wait until everything is written, including the pages of unfinished episodes and the index."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()

    def _write_all(self) -> None:
        try:
            while (item := self._queue.get()) is not None:
                if isinstance(item, _StepEntry):
                    with self._lock:
                        self._waiting -= item.waiting
                if self.error is None:
                    self._guarded(self._write, item)
            if self.error is None:
                self._guarded(self._finish)
        finally:
            for files in self._open.values():
                files.abandon()

    def _guarded(self, write: Callable[..., None], *arguments: object) -> None:
        try:
            write(*arguments)
        except (OSError, OutputError) as error:
            reason = error.strerror or str(error) if isinstance(error, OSError) else str(error)
            self.error = OutputError(f"the recording in {self.folder} is incomplete: {reason}")
            self._notify(f"warning: {self.error}. The run continues without recording")

    def _write(self, item: _BeginEntry | _StepEntry | _EndEntry) -> None:
        match item:
            case _BeginEntry(episode):
                before = self._open.pop(episode.episode_id, None)
                if before is not None:
                    before.abandon()
                self._open[episode.episode_id] = EpisodeFiles(self.folder / folder_name(episode.episode_id), episode)
            case _StepEntry(observation, action, left_out):
                files = self._open.get(observation.episode_id)
                if files is not None:
                    files.step(observation, action, left_out=left_out)
            case _EndEntry(episode_id, cause):
                self._end(episode_id, cause)

    def _end(self, episode_id: str, cause: str) -> None:
        files = self._open.get(episode_id)
        if files is None:
            return
        files.end(cause)
        del self._open[episode_id]
        page.write_page(files.folder, self._facts())

    def _finish(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        for episode_id in list(self._open):
            self._end(episode_id, "")
        page.write_index(self.folder, self._facts())

    def _facts(self) -> Mapping[str, str]:
        run = self._run
        arguments = ", ".join(f"{each.name}={each.value}" for each in run.agent_arguments)
        return {
            "run": run.run_id,
            "agent": run.agent + (f" ({arguments})" if arguments else ""),
            "split": run.split,
            "language": run.language,
        }
