"""Resumable, parallel export of demonstrations in parts, for `arramon-server export-demos`."""

import errno
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from arramon_dataset.demonstrations.description import record_of
from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.formats import load_format
from arramon_dataset.demonstrations.job_runner import run_jobs
from arramon_dataset.demonstrations.parts import ExportPart, episodes_by_language, make_parts
from arramon_dataset.demonstrations.request import ExportRequest, ResolvedExport, check_request
from arramon_dataset.demonstrations.sources import EpisodeSelection
from arramon_dataset.parallel import processes_of
from arramon_server.episodes.splits import Split, read_named_split
from arramon_server.errors import BadInput, Conflict, StorageError
from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.physics import problem_of_camera
from arramon_server.sim.raster.camera import compile_kernels

CAMERA = "ARRAMON_CAMERA"
"""Environment variable that selects the camera, as for the environments."""

DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Error numbers that mean a full disk or quota."""


@dataclass(frozen=True, slots=True)
class ExportProgress:
    """The progress of an export.

    Attributes:
        export: the export.
        parts, episodes, steps, size: finished so far, including earlier attempts; size in bytes.
        fresh: steps finished in this attempt.
        seconds: since the start of this attempt.
    """

    export: ResolvedExport
    parts: int
    episodes: int
    steps: int
    size: int
    fresh: int
    seconds: float

    def __str__(self) -> str:
        export = self.export
        left = self.seconds / self.fresh * (export.steps - self.steps) if self.fresh else 0.0
        return (
            f"{export.request.split}: {self.episodes} of {export.episodes} episodes, {self.steps} steps, "
            f"{self.size / 1e6:.1f} of about {self.size / max(self.steps, 1) * export.steps / 1e6:.1f} MB "
            f"in {_clock(self.seconds)}, {_clock(left)} left"
        )


OnProgress = Callable[[ExportProgress], None]
"""Receives the progress, in the thread that exports."""


@dataclass(frozen=True, slots=True)
class PartJob:
    """A part to export, as sent to a worker process."""

    export: ResolvedExport
    folder: Path
    part: ExportPart


def complete_request(request: ExportRequest, split: Split) -> ExportRequest:
    """Return the request with its languages filled in, checked against the split.

    Raises:
        Forbidden: if the split is hidden.
        BadInput: if the split lacks a language or a sensor.
    """
    filled = request if request.languages else replace(request, languages=tuple(sorted(split.languages)))
    check_request(filled, split)
    return filled


def export_demonstrations(
    request: ExportRequest,
    split: Split,
    sources: EpisodeSelection,
    output: Path,
    *,
    jobs: int = 0,
    on_progress: OnProgress,
) -> ResolvedExport:
    """Export demonstrations to a folder, resuming an earlier attempt with the same settings.

    The same settings and data give the same files, for any number of processes and attempts.

    Args:
        request: the settings, with languages filled in.
        split: the split to export.
        sources: the actions to export.
        output: the folder.
        jobs: number of processes; 0 for one per core.
        on_progress: called with the progress, in this thread.

    Raises:
        BadInput: if libraries of the format are not installed, there is nothing to export, or the folder contains
            other files.
        Conflict: if the folder contains an export with other settings, or another export is writing to it.
        StorageError: if the folder cannot be written; finished parts are kept.
        ArraMonError: if a demonstration does not fit its episode.
    """
    processes = processes_of(jobs)
    format_ = load_format(request.format)
    parts = make_parts(split, request, sources.chosen)
    if not parts:
        raise BadInput(f"there is nothing to export: the split {split.name!r} has no episode to demonstrate")
    camera = os.environ.get(CAMERA) or CAMERAS[0]
    problem = problem_of_camera(camera)
    if problem:
        raise BadInput(f"{CAMERA} is {camera!r}, {problem}")
    last = parts[-1]
    export = ResolvedExport(
        request, split.data_hash, split.source, camera, sources.steps_per_phase, len(parts),
        last.demonstrations_before + last.demonstrations, last.steps_before + last.steps,
    )  # fmt: skip
    folder = ExportFolder(output)
    try:
        if folder.begin(export.settings()):
            return export
        with folder.locked():
            _write_missing_parts(export, folder, parts, processes, on_progress)
            done = folder.finished_parts()
            format_.finish(export, split, folder, [done[part.number]["content"] for part in parts])
            folder.write_record(record_of(export, episodes_by_language(parts)))
            folder.end()
    except OSError as error:
        raise _unwritable(folder, export, error) from error
    return export


def _write_missing_parts(
    export: ResolvedExport,
    folder: ExportFolder,
    parts: list[ExportPart],
    processes: int,
    on_progress: OnProgress,
) -> None:
    """Write all parts that are not finished yet."""
    begun = time.monotonic()
    finished = {number: int(record["size"]) for number, record in folder.finished_parts().items()}
    left = [part for part in parts if part.number not in finished]
    first = sum(part.steps for part in parts if part.number in finished)
    if left and export.request.size and export.camera == CAMERAS[0]:
        compile_kernels()  # Once here, instead of in each process.
    jobs = [PartJob(export, folder.path, part) for part in left]
    for number, size in run_jobs(write_part, jobs, min(processes, max(1, len(jobs)))):
        finished[number] = size
        done = [part for part in parts if part.number in finished]
        steps = sum(part.steps for part in done)
        on_progress(
            ExportProgress(
                export,
                len(done),
                sum(part.demonstrations for part in done),
                steps,
                sum(finished.values()),
                steps - first,
                time.monotonic() - begun,
            )
        )


def write_part(job: PartJob) -> tuple[int, int]:
    """Write one part; return its number and the size of its files in bytes."""
    folder = ExportFolder(job.folder)
    made = folder.scratch(f"{job.part.number:05d}")
    try:
        content = load_format(job.export.request.format).write_part(job.export, _split(job.export), job.part, made)
        size = sum(path.stat().st_size for path in made.rglob("*") if path.is_file())
        folder.finish_part(job.part.number, made, {"size": size, "content": content})
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return job.part.number, size


@lru_cache(maxsize=2)
def _split(export: ResolvedExport) -> Split:
    split = read_named_split(export.request.data, export.request.split)
    if split.data_hash != export.data_hash:
        raise Conflict(f"the data of split {split.name!r} has changed during the export; start again")
    return split


def _unwritable(folder: ExportFolder, export: ResolvedExport, error: OSError) -> StorageError:
    kept = f"{len(folder.finished_parts())} of {export.parts} parts are finished and stay"
    if error.errno in DISK_FULL:
        return StorageError(
            f"there is no room left in {folder.path} ({os.strerror(error.errno)}): {kept}. Make room there, or move "
            "the folder to a larger disk and name it with --output; the same command then goes on where this one ended"
        )
    why = (error.strerror or str(error)) + (f": {error.filename}" if error.filename else "")
    return StorageError(f"cannot write to {folder.path}: {why}; {kept}; the same command goes on with them")


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"
