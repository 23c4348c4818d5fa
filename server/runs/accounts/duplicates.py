"""Search for runs of different accounts with equal or almost equal actions, for the host to review.

Public deterministic agents produce such runs, too: a pair is a reason to ask its participants, not a proof.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import sqlalchemy as sa

from arramon_server.errors import BadInput
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import run_of
from arramon_server.runs.storage.records import Run

MIN_STEPS = 50
"""Minimum steps in the common episodes of two runs to compare them: a few equal steps prove nothing."""


Actions: TypeAlias = dict[str, npt.NDArray[np.uint8]]
"""Actions of a run's episodes that have any, by episode."""


@dataclass(frozen=True, slots=True)
class DuplicatePair:
    """Two runs of different accounts, the earlier one first.

    Attributes:
        episodes: number of episodes in which both took steps.
        same: number of these with equal actions.
        likeness: mean over those episodes of the share of steps, of the longer sequence, with the same action; 1 if
            all are equal.
    """

    earlier: Run
    later: Run
    episodes: int
    same: int
    likeness: float


def find_duplicates(database: Database, min_likeness: float, split: str | None = None) -> Iterator[DuplicatePair]:
    """Yield the pairs of runs on the same split, in any language, whose likeness is at least `min_likeness`.

    Actions are compared by their step numbers: sequences that were shifted on purpose are not found.

    Args:
        database: database of the journal.
        min_likeness: 0 to 1.
        split: compare only runs on this split; None for all splits.

    Raises:
        BadInput: if `min_likeness` is out of range.
        StorageError: if the journal cannot be read.
    """
    if not 0.0 <= min_likeness <= 1.0:
        raise BadInput(f"the likeness is {min_likeness:g}, expected 0 to 1")
    c = tables.runs.c
    query = sa.select(tables.runs).order_by(c.created_at, c.run_id)
    by_split: dict[str, list[Run]] = {}
    for run in map(run_of, database.read(query if split is None else query.where(c.split == split))):
        by_split.setdefault(run.split, []).append(run)
    for runs in by_split.values():
        if len({run.account for run in runs}) > 1:
            yield from _pairs(database, runs, min_likeness)


def likeness_of(one: Actions, other: Actions) -> tuple[int, int, float] | None:
    """Return the fields `episodes`, `same` and `likeness` of a pair; None if the two have too little in common."""
    common = [name for name in one if name in other]
    shares = [_share(one[name], other[name]) for name in common]
    if sum(min(len(one[name]), len(other[name])) for name in common) < MIN_STEPS:
        return None
    return len(common), sum(share == 1.0 for share in shares), float(np.mean(shares))


def _pairs(database: Database, runs: Sequence[Run], min_likeness: float) -> Iterator[DuplicatePair]:
    actions = {run.run_id: _actions(database, run.run_id) for run in runs}
    for earlier, later in combinations(runs, 2):
        if earlier.account == later.account:
            continue
        found = likeness_of(actions[earlier.run_id], actions[later.run_id])
        if found is not None and found[2] >= min_likeness:
            yield DuplicatePair(earlier, later, *found)


def _share(one: npt.NDArray[np.uint8], other: npt.NDArray[np.uint8]) -> float:
    both = min(len(one), len(other))
    return float(np.count_nonzero(one[:both] == other[:both]) / max(len(one), len(other)))


def _actions(database: Database, run_id: str) -> Actions:
    c = tables.steps.c
    query = sa.select(c.episode_id, c.action).where(c.run_id == run_id).order_by(c.episode_id, c.step)
    found: dict[str, bytearray] = {}
    for row in database.read(query):
        found.setdefault(row.episode_id, bytearray()).append(row.action)
    return {name: np.frombuffer(actions, np.uint8) for name, actions in found.items()}
