"""Makes splits in the data folder: what `arramon-server generate` does."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from server.episodes.generate.secret import host_secret
from server.episodes.generate.sizes import SplitPlan
from server.episodes.generate.work import Made, MakeWriter, Order, Run, orders_of, workshop
from server.episodes.plans import build_section, read_plan
from server.episodes.splits import Split, write_split
from server.errors import BadInput
from server.sim.section import Section

SOURCE = "generated"
"""How the `source` of a generated split begins."""

MAX_JOBS = 256


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a split is.

    Attributes:
        split: its name.
        done, total: episodes.
        drafts: how many it took so far, those that were given up included.
        seconds: since the split was begun.
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
    """Makes splits, each written when it is whole; one that was there before is replaced then.

    The same seed, scale and version of the project give the same bytes on any machine. A hidden split comes from the
    host's secret in place of the seed (see `secret`).

    Args:
        data: the data folder.
        plans: of the splits.
        scale: share of each split's size, in (0, 1].
        seed: draws the furniture, facades and episodes.
        jobs: processes; 0 for one a core.
        make_writer: makes what writes the instructions.
        tell: is told of progress, in this thread.

    Returns:
        The splits that were written.

    Raises:
        BadInput: for a scale or a number of jobs out of range.
        BadFile: if the host's secret is not one, or can be read by others.
        StorageError: if the data folder cannot be written.
        ArraMonError: if an episode cannot be made.
    """
    if not 0 <= jobs <= MAX_JOBS:
        raise BadInput(f"{jobs} jobs were asked for, expected 1 to {MAX_JOBS}, or 0 for one a core")
    episodes = {plan.name: list(plan.episodes(scale)) for plan in plans}
    with workshop(jobs or len(os.sched_getaffinity(0))) as run:
        written = []
        for plan in plans:
            key = host_secret(data) if plan.hidden else str(seed)
            sections = {name: _section(key, name) for name in plan.sections}
            made = _made(run, plan.name, orders_of(key, plan.name, episodes[plan.name], sections, make_writer), tell)
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


def _made(run: Run, split: str, orders: Sequence[Order], tell: Callable[[Progress], None]) -> list[Made]:
    begun, made = time.monotonic(), []
    total = sum(len(order.episode_ids) for order in orders)
    for batch in run(orders):
        made += batch
        drafts = sum(one.attempts for one in made)
        tell(Progress(split, len(made), total, drafts, time.monotonic() - begun))
    return made


@lru_cache(maxsize=16)
def _section(key: str, plan_id: str) -> Section:
    """Splits share sections, and to build one takes a second or two."""
    return build_section(read_plan(plan_id), key)
