"""Simulated walks of episodes for the training of `vl_map`, in one process or in several."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from arramon_agents.process_settings import prepare_process
from arramon_agents.simulated.body import PerceptionErrorRates
from arramon_agents.simulated.courses import Course
from arramon_agents.simulated.walks import LabelledDecision, walk
from arramon_agents.vl_map.network import PolicyNetwork
from arramon_agents.vl_map.policy import MapPolicy
from arramon_dataset.parallel import process_pool

PERFECT_SHARE = 0.25
"""Share of walks without perception errors; the others have 0.5 to 1.5 times the measured error rates."""

CHUNK = 4
"""Number of episodes that a process is given at a time."""

CoursePair = tuple[Course, Course]
"""Courses of the two turns of an episode."""


class PlannedWalk(NamedTuple):
    """A walk of both turns of an episode.

    Attributes:
        pair: index of the courses.
        reading: index of the first turn's reading; the second turn uses the next one.
        seed: seed of perception errors and of random detours.
    """

    pair: int
    reading: int
    seed: tuple[int, ...]


class EpisodeWalk(NamedTuple):
    """Result of a planned walk: labelled decisions, and the number of targets that were picked up."""

    decisions: list[LabelledDecision]
    picked: int


class Walker(Protocol):
    """Walks planned walks."""

    def walk(self, planned: PlannedWalk) -> EpisodeWalk:
        """Walk both turns of an episode."""


def walk_episodes(
    pairs: Sequence[CoursePair], planned: Sequence[PlannedWalk], network: PolicyNetwork | None, processes: int = 1
) -> Iterator[EpisodeWalk]:
    """Return the results of walks in order; they do not depend on the number of processes.

    Args:
        pairs: courses of the episodes.
        planned: the walks.
        network: network of the policy that walks, on the CPU, in evaluation mode; None for walks along the paths.
        processes: number of processes.
    """
    return walk_in_processes(partial(_Walker, pairs, network), planned, processes, "simulates walks")


def walk_in_processes(
    make: Callable[[], Walker], planned: Sequence[PlannedWalk], processes: int, work: str
) -> Iterator[EpisodeWalk]:
    """Yield the results of walks in order.

    Args:
        make: makes the walker of a process; it can be pickled.
        planned: the walks.
        processes: number of processes.
        work: what each of them does, for the message if one dies.
    """
    if processes <= 1:
        yield from map(make().walk, planned)
        return
    with process_pool(processes, work, _begin_process, make) as pool:
        yield from pool.map(_walk_in_process, planned, chunksize=CHUNK)
        pool.shutdown()  # Waits, so that `cpu_seconds` counts the processes.


def walk_turns(pair: CoursePair, reading: int, seed: Sequence[int], policy: MapPolicy | None = None) -> EpisodeWalk:
    """Walk both turns of an episode; the second starts where the first ended.

    Args:
        pair: courses of the two turns.
        reading: index of the first turn's reading; the second turn uses the next one.
        seed: seed of perception errors and of random detours.
        policy: policy that walks; None for walks along the paths.
    """
    draws = np.random.default_rng(tuple(seed))
    faults = PerceptionErrorRates().scaled(0.0 if draws.random() < PERFECT_SHARE else draws.uniform(0.5, 1.5))
    decided: list[LabelledDecision] = []
    picked, body = 0, None
    for course in pair:
        # The two turns use different readings.
        rows = course.readings[(reading + course.turn) % len(course.readings)]
        if policy is None:
            walked = walk(course, rows, faults, draws, body=body)
        else:
            walked = walk(course, rows, faults, draws, policy.option_values, astray=0.05, body=body)
        decided += walked.decisions
        picked += walked.picked == 0
        body = walked.body
    return EpisodeWalk(decided, picked)


def cpu_seconds() -> float:
    """Return the processor time of this process and of the finished processes that it started, in seconds."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@dataclass(frozen=True)
class _Walker:
    """Walks planned walks.

    Attributes:
        pairs: courses of the episodes.
        network: network of the policy; None for walks along the paths.
    """

    pairs: Sequence[CoursePair]
    network: PolicyNetwork | None

    def walk(self, planned: PlannedWalk) -> EpisodeWalk:
        policy = None if self.network is None else MapPolicy([self.network])
        return walk_turns(self.pairs[planned.pair], planned.reading, planned.seed, policy)


_walkers: list[Walker] = []
"""The walker of this process, if it is one of several."""


def _begin_process(make: Callable[[], Walker]) -> None:
    prepare_process()
    _walkers[:] = [make()]


def _walk_in_process(planned: PlannedWalk) -> EpisodeWalk:
    return _walkers[0].walk(planned)
