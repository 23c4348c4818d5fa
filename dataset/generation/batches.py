"""Batches of episodes to generate, on any number of processes with the same result in the same order."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

from arramon_dataset.generation.check import faults_of_episode
from arramon_dataset.generation.draft_writer import DraftWriter
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.parallel import process_pool
from arramon_dataset.plans.plan import Plan
from arramon_server.episodes.episode import Episode
from arramon_server.errors import ArraMonError
from arramon_server.sim.section import Section

ATTEMPTS = 100
"""Maximum number of drafts for one episode."""

SECOND_TURNS = 6
"""Maximum number of second turns drawn for one valid first turn."""

BATCH_SIZE = 6
"""Episodes in one batch."""

CACHED_SECTIONS = 7
"""Number of sections cached by each process."""

MakeWriter = Callable[[], DraftWriter]
"""Creates the instruction writer of a process. Picklable and hashable, such as a module-level function."""


@dataclass(frozen=True, slots=True)
class GeneratedEpisode:
    """A generated episode, and the number of drafts tried, the accepted one included."""

    episode: Episode
    attempts: int


class GenerationBatch(Protocol):
    """Some episodes to generate, as a picklable unit of work."""

    def generate(self) -> list[GeneratedEpisode]:
        """Generate the episodes, one after another."""


@dataclass(frozen=True, slots=True)
class EpisodeBatch:
    """Episodes of one section to generate.

    Attributes:
        seed: of all random choices.
        split: name of the split.
        plan: street plan of the section.
        section: where the episodes take place.
        episode_ids: ids of the episodes.
        make_writer: see `MakeWriter`.
    """

    seed: str
    split: str
    plan: Plan
    section: Section
    episode_ids: tuple[str, ...]
    make_writer: MakeWriter

    def generate(self) -> list[GeneratedEpisode]:
        """Generate the episodes, one after another.

        Raises:
            ArraMonError: if no valid episode is found for an id.
        """
        site, writer = _site(self.section, self.plan), _writer(self.make_writer)
        return [_make(self, episode_id, site, writer) for episode_id in self.episode_ids]


RunBatches = Callable[[Sequence[GenerationBatch]], Iterator[list[GeneratedEpisode]]]


@contextmanager
def batch_runner(jobs: int) -> Iterator[RunBatches]:
    """Yield a function that runs batches on `jobs` processes, in this one if `jobs` is 1, and yields results in order.

    Raises:
        ArraMonError: when results are read, if a child process has died.
    """
    if jobs == 1:
        yield lambda batches: map(_generate, batches)
        return
    with process_pool(jobs, "generates episodes") as pool:
        yield lambda batches: pool.map(_generate, batches)


def make_batches(
    seed: str,
    split: str,
    episodes: Iterable[tuple[str, str]],
    sections: Mapping[str, tuple[Plan, Section]],
    make_writer: MakeWriter,
) -> list[EpisodeBatch]:
    """Return batches for pairs of episode id and section id, by section; `sections` maps ids to plan and section."""
    by_section: dict[str, list[str]] = {}
    for episode_id, section in episodes:
        by_section.setdefault(section, []).append(episode_id)
    return [
        EpisodeBatch(seed, split, *sections[section], tuple(ids[first : first + BATCH_SIZE]), make_writer)
        for section, ids in by_section.items()
        for first in range(0, len(ids), BATCH_SIZE)
    ]


def _generate(batch: GenerationBatch) -> list[GeneratedEpisode]:
    return batch.generate()


def _make(batch: EpisodeBatch, episode_id: str, site: GenerationSite, writer: DraftWriter) -> GeneratedEpisode:
    tried = 0
    while tried < ATTEMPTS:
        names = (batch.seed, batch.split, episode_id, tried)
        words = (*names, "words")
        begun = site.sampler.begin((*names, "draft"))
        tried += 1
        if not writer.can_describe(begun.start, begun.turn, 1, site, words):
            continue
        for number in range(SECOND_TURNS):
            draft = site.sampler.complete(begun, episode_id, (*names, "second", number))
            if draft is None:
                break
            tried += number > 0
            if not writer.can_describe(begun.end, draft.turns[1], 2, site, words) or faults_of_episode(
                draft, site.solids, site.physics
            ):
                continue
            instructions = writer(draft, site, words)
            if instructions is not None:
                return GeneratedEpisode(draft.with_instructions(instructions), tried)
    raise ArraMonError(f"no valid episode {episode_id} of split {batch.split} found in {ATTEMPTS} attempts")


@lru_cache(maxsize=CACHED_SECTIONS)
def _site(section: Section, plan: Plan) -> GenerationSite:
    return GenerationSite(section, plan)


@lru_cache(maxsize=1)
def _writer(make: MakeWriter) -> DraftWriter:
    return make()
