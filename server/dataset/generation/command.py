"""Generation of splits in the data folder, for `arramon-server generate`."""

import os
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from server.dataset.generation.checkpoint import FOLDER, Checkpoint, origin_of
from server.dataset.generation.secret import host_secret
from server.dataset.generation.sizes import SplitPlan
from server.dataset.generation.work import (
    EpisodeBatch,
    GeneratedEpisode,
    MakeWriter,
    RunBatches,
    batch_runner,
    make_batches,
)
from server.dataset.plans import build_section, read_plan
from server.episodes.splits import Split, write_split
from server.errors import BadInput
from server.sim.section import Section

SOURCE = "generated"
"""Prefix of the `source` of generated splits."""

NO_TRIAL = "not tried by the follower"
"""Mark in the `source` of a split whose instructions no agent has tried."""

MAX_JOBS = 256


@dataclass(frozen=True, slots=True)
class Progress:
    """The progress of a split.

    Attributes:
        split: name of the split.
        done, total: numbers of episodes.
        drafts: number of drafts tried so far, rejected ones included.
        seconds: since the split was started, or gone on with.
        kept: how many of the episodes an earlier call made that was killed.
    """

    split: str
    done: int
    total: int
    drafts: int
    seconds: float
    kept: int = 0

    def __str__(self) -> str:
        if self.done == self.kept:
            return f"{self.split}: going on after {self.done} of {self.total} episodes"
        left = self.seconds / (self.done - self.kept) * (self.total - self.done)
        return (
            f"{self.split}: {self.done} of {self.total} episodes from {self.drafts} drafts "
            f"in {_clock(self.seconds)}, {_clock(left)} left"
        )


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def generate(
    data: Path,
    plans: Sequence[SplitPlan],
    *,
    scale: float = 1.0,
    seed: int = 0,
    jobs: int = 0,
    make_writer: MakeWriter,
    tell: Callable[[Progress], None],
    tried: bool = True,
) -> list[Split]:
    """Generate splits. Each is written when it is complete, and replaces an existing split of that name only then.

    Episodes of an incomplete split are kept in the data folder (see `checkpoint`), and not made again by the next call.

    The same seed, scale and version of the project give the same bytes on any machine. A hidden split is seeded by the
    host's secret instead of `seed` (see `secret`).

    Args:
        data: the data folder.
        plans: specifications of the splits.
        scale: share of each split's size, in (0, 1].
        seed: seeds furniture, facades and episodes.
        jobs: number of processes; 0 for one per core.
        make_writer: returns the instruction writer of a process.
        tell: receives the progress, in this thread.
        tried: whether an agent tries what the writer writes; the header of a split says if not.

    Returns:
        The splits that were written.

    Raises:
        BadInput: if the scale or the number of jobs is out of range.
        BadFile: if the host's secret is malformed, or others can read it.
        StorageError: if the data folder cannot be written.
        Conflict: if another process generates one of the splits in this data folder.
        ArraMonError: if an episode cannot be made.
    """
    if not 0 <= jobs <= MAX_JOBS:
        raise BadInput(f"the number of jobs is {jobs}; expected 1 to {MAX_JOBS}, or 0 for one per core")
    sizes = [(plan, list(plan.episodes(scale))) for plan in plans]  # Checks the scale before anything is made.
    with batch_runner(jobs or len(os.sched_getaffinity(0))) as run:
        written = []
        for plan, episodes in sizes:
            key = host_secret(data) if plan.hidden else str(seed)
            source = f"{SOURCE}, scale {scale:g}, " + ("from the host's secret" if plan.hidden else f"seed {seed}")
            sections = {name: _section(key, name) for name in plan.sections}
            origin = origin_of(key, make_writer.__module__, make_writer.__qualname__)
            with closing(Checkpoint(data / FOLDER / f"{plan.name}.jsonl", origin)) as checkpoint:
                missing = [(name, section) for name, section in episodes if name not in checkpoint.episodes]
                kept = [checkpoint.episodes[name] for name, _ in episodes if name in checkpoint.episodes]
                batches = make_batches(key, plan.name, missing, sections, make_writer)
                made = kept + _generate_episodes(run, plan.name, batches, kept, checkpoint, tell)
                split = write_split(
                    data,
                    plan.name,
                    hidden=plan.hidden,
                    source=source if tried else f"{source}, {NO_TRIAL}",
                    episodes=sorted((one.episode for one in made), key=lambda episode: int(episode.episode_id)),
                    sections=sections.values(),
                )
                checkpoint.remove()
            written.append(split)
    return written


def _generate_episodes(
    run: RunBatches,
    split: str,
    batches: Sequence[EpisodeBatch],
    kept: Sequence[GeneratedEpisode],
    checkpoint: Checkpoint,
    tell: Callable[[Progress], None],
) -> list[GeneratedEpisode]:
    """Return the episodes of the batches. Each batch is written down before the next one is waited for."""
    begun, made, drafts = time.monotonic(), [], sum(one.attempts for one in kept)
    total = len(kept) + sum(len(batch.episode_ids) for batch in batches)
    if kept:
        tell(Progress(split, len(kept), total, drafts, 0.0, len(kept)))
    for generated in run(batches):
        checkpoint.add(generated)
        made += generated
        drafts += sum(one.attempts for one in generated)
        tell(Progress(split, len(kept) + len(made), total, drafts, time.monotonic() - begun, len(kept)))
    return made


@lru_cache(maxsize=16)
def _section(key: str, plan_id: str) -> Section:
    """Return a section; cached, since splits share sections and building one takes a second or two."""
    return build_section(read_plan(plan_id), key)
