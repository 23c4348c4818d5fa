"""Generation of one split: runs batches of episodes, checkpoints their results, and writes the split at the end."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from arramon_dataset.generation.batches import GeneratedEpisode, GenerationBatch, RunBatches
from arramon_dataset.generation.checkpoint import FOLDER, GenerationCheckpoint, generation_digest
from arramon_server.episodes.episode import Episode, languages_of
from arramon_server.episodes.splits import Split, write_split
from arramon_server.sim.section import Section

SOURCE = "generated"
"""Prefix of the `source` of generated splits."""


@dataclass(frozen=True, slots=True)
class SplitRequest:
    """A request to generate a split.

    Attributes:
        name: of the split.
        source: origin of the split, as free text, without the prefix `SOURCE`.
        key: seed or host's secret, and everything else but their ids that determines the episodes.
        episode_ids: in the split's order.
        sections: of the episodes.
        batches: returns the batches that generate the episodes with the given ids.
        hidden, training: see `arramon_server.episodes.splits.Split`.
        further: codes of the languages that an episode may lack, and what the split's `source` calls each
            ("te (preview)"), where it says how many episodes have them.
    """

    name: str
    source: str
    key: tuple[object, ...]
    episode_ids: Sequence[str]
    sections: Iterable[Section]
    batches: Callable[[Sequence[str]], Sequence[GenerationBatch]]
    hidden: bool = False
    training: bool = False
    further: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class GenerationProgress:
    """The progress of a split's generation.

    Attributes:
        split: name of the split.
        done, total: numbers of episodes.
        drafts: number of drafts tried so far, rejected ones included.
        seconds: since this call started or resumed the split.
        kept: number of episodes from the checkpoint of an earlier call.
    """

    split: str
    done: int
    total: int
    drafts: int
    seconds: float
    kept: int = 0

    def __str__(self) -> str:
        if not self.done:
            return f"{self.split}: 0 of {self.total} episodes; the first ones take longest"
        if self.done == self.kept:
            return f"{self.split}: going on after {self.done} of {self.total} episodes"
        left = self.seconds / (self.done - self.kept) * (self.total - self.done)
        return (
            f"{self.split}: {self.done} of {self.total} episodes from {self.drafts} drafts "
            f"in {_clock(self.seconds)}, {_clock(left)} left"
        )


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def make_split(
    data: Path, request: SplitRequest, run: RunBatches, on_progress: Callable[[GenerationProgress], None]
) -> Split:
    """Generate a split and write it, resuming from the checkpoint of an interrupted call.

    Args:
        data: the data folder.
        request: the split to generate.
        run: runs batches and yields their results in order.
        on_progress: called with the progress, in this thread.

    Raises:
        StorageError: if the data folder cannot be written.
        Conflict: if another process is generating the split in this data folder.
        ArraMonError: if no valid episode is found for an id.
    """
    with closing(
        GenerationCheckpoint(data / FOLDER / f"{request.name}.jsonl", generation_digest(*request.key))
    ) as checkpoint:
        kept = [checkpoint.episodes[name] for name in request.episode_ids if name in checkpoint.episodes]
        missing = [name for name in request.episode_ids if name not in checkpoint.episodes]
        made = {one.episode.episode_id: one.episode for one in kept}
        for one in _generate(request, missing, kept, run, checkpoint, on_progress):
            made[one.episode.episode_id] = one.episode
        episodes = [made[name] for name in request.episode_ids]
        split = write_split(
            data,
            request.name,
            hidden=request.hidden,
            training=request.training,
            source=f"{SOURCE}, {request.source}{_counted(request.further, episodes)}",
            episodes=episodes,
            sections=request.sections,
        )
        checkpoint.remove()
    return split


def _counted(further: Mapping[str, str], episodes: Sequence[Episode]) -> str:
    """Return the number of episodes in each further language, for `source`: ", te in 22 of 24"."""
    have = languages_of(episodes)
    return "".join(f", {name} in {have.get(code, 0)} of {len(episodes)}" for code, name in further.items())


def _generate(
    request: SplitRequest,
    missing: Sequence[str],
    kept: Sequence[GeneratedEpisode],
    run: RunBatches,
    checkpoint: GenerationCheckpoint,
    on_progress: Callable[[GenerationProgress], None],
) -> list[GeneratedEpisode]:
    """Generate the missing episodes. Each batch is checkpointed before the next result is awaited."""
    begun, made, drafts = time.monotonic(), [], sum(one.attempts for one in kept)
    total = len(kept) + len(missing)
    on_progress(GenerationProgress(request.name, len(kept), total, drafts, 0.0, len(kept)))
    for generated in run(request.batches(missing)):
        checkpoint.add(generated)
        made += generated
        drafts += sum(one.attempts for one in generated)
        on_progress(
            GenerationProgress(request.name, len(kept) + len(made), total, drafts, time.monotonic() - begun, len(kept))
        )
    return made
