"""Parts of an export: the units of parallel work, and of resuming after a kill."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from arramon_dataset.demonstrations.request import ExportRequest
from arramon_dataset.demonstrations.sources import EpisodeActions
from arramon_server.episodes.splits import Split


@dataclass(frozen=True, slots=True)
class ExportPart:
    """One part of an export: some episodes, and the counts of all earlier parts.

    Each language of an episode is a demonstration.

    Attributes:
        number: from 0.
        sources: the episodes, with their actions.
        before: number of demonstrations in all earlier parts, by language.
        steps_before: number of steps of all demonstrations in all earlier parts.
        tasks: task index of each instruction text of the part; equal texts share an index in all parts.
    """

    number: int
    sources: tuple[EpisodeActions, ...]
    before: Mapping[str, int]
    steps_before: int
    tasks: Mapping[str, int]

    @property
    def demonstrations_before(self) -> int:
        """Number of demonstrations in all earlier parts, in all languages."""
        return sum(self.before.values())

    @property
    def demonstrations(self) -> int:
        """Number of demonstrations in this part."""
        return sum(len(source.languages) for source in self.sources)

    @property
    def steps(self) -> int:
        """Number of steps of all demonstrations in this part."""
        return sum(len(source.languages) * len(source.actions) for source in self.sources)


def make_parts(split: Split, request: ExportRequest, sources: Sequence[EpisodeActions]) -> list[ExportPart]:
    """Divide an export into parts, which depend only on its settings and the split."""
    parts: list[ExportPart] = []
    before = dict.fromkeys(request.languages, 0)
    steps = 0
    numbers: dict[str, int] = {}
    for first in range(0, len(sources), request.part_size):
        some = tuple(sources[first : first + request.part_size])
        tasks = {
            text: numbers.setdefault(text, len(numbers))
            for source in some
            for language in source.languages
            for text in phase_texts(split, source, language)
        }
        part = ExportPart(len(parts), some, dict(before), steps, tasks)
        parts.append(part)
        steps += part.steps
        for source in some:
            for language in source.languages:
                before[language] += 1
    return parts


def phase_texts(split: Split, source: EpisodeActions, language: str) -> list[str]:
    """Return the instructions of an episode in the order of its phases."""
    turns = split.episodes[source.episode_id].instructions[language]
    return [text for turn in turns for text in (turn.navigation, turn.assembly)]


def episodes_by_language(parts: Sequence[ExportPart]) -> dict[str, int]:
    """Return the number of demonstrations in each language."""
    counts = dict(parts[-1].before)
    for source in parts[-1].sources:
        for language in source.languages:
            counts[language] += 1
    return counts
