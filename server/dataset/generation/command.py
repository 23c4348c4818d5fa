"""Generation of splits in the data folder, for `arramon-server generate`."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

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

MAX_JOBS = 256


@dataclass(frozen=True, slots=True)
class Progress:
    """The progress of a split.

    Attributes:
        split: name of the split.
        done, total: numbers of episodes.
        drafts: number of drafts tried so far, rejected ones included.
        seconds: since the split was started.
    """

    split: str
    done: int
    total: int
    drafts: int
    seconds: float

    def __str__(self) -> str:
        left = self.seconds / self.done * (self.total - self.done)
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
) -> list[Split]:
    """Generate splits. Each is written when it is complete, and replaces an existing split of that name only then.

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

    Returns:
        The splits that were written.

    Raises:
        BadInput: if the scale or the number of jobs is out of range.
        BadFile: if the host's secret is malformed, or others can read it.
        StorageError: if the data folder cannot be written.
        ArraMonError: if an episode cannot be made.
    """
    if not 0 <= jobs <= MAX_JOBS:
        raise BadInput(f"the number of jobs is {jobs}; expected 1 to {MAX_JOBS}, or 0 for one per core")
    episodes = {plan.name: list(plan.episodes(scale)) for plan in plans}
    with batch_runner(jobs or len(os.sched_getaffinity(0))) as run:
        written = []
        for plan in plans:
            key = host_secret(data) if plan.hidden else str(seed)
            sections = {name: _section(key, name) for name in plan.sections}
            made = _generate_episodes(
                run, plan.name, make_batches(key, plan.name, episodes[plan.name], sections, make_writer), tell
            )
            source = f"{SOURCE}, scale {scale:g}, " + ("from the host's secret" if plan.hidden else f"seed {seed}")
            written.append(
                write_split(
                    data,
                    plan.name,
                    hidden=plan.hidden,
                    source=source,
                    episodes=sorted((one.episode for one in made), key=lambda episode: int(episode.episode_id)),
                    sections=sections.values(),
                )
            )
    return written


def _generate_episodes(
    run: RunBatches, split: str, batches: Sequence[EpisodeBatch], tell: Callable[[Progress], None]
) -> list[GeneratedEpisode]:
    begun, made = time.monotonic(), []
    total = sum(len(batch.episode_ids) for batch in batches)
    for generated in run(batches):
        made += generated
        drafts = sum(one.attempts for one in made)
        tell(Progress(split, len(made), total, drafts, time.monotonic() - begun))
    return made


@lru_cache(maxsize=16)
def _section(key: str, plan_id: str) -> Section:
    """Return a section; cached, since splits share sections and building one takes a second or two."""
    return build_section(read_plan(plan_id), key)
