"""Statistics of one split's instructions in one language."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from arramon_client.world import PHASES
from arramon_dataset.statistics.diversity import SAMPLE, Diversity, diversity
from arramon_dataset.statistics.lengths import PhaseLengths, lengths_of
from arramon_dataset.statistics.properties import PROPERTIES, load_patterns
from arramon_dataset.statistics.words import words_of
from arramon_lang import Language, Mention, UnknownLanguage, load
from arramon_server.episodes.episode import Episode
from arramon_server.errors import NotFound

FREQUENT = 25
"""Number of most frequent words in the report, as in the paper's figure."""


@dataclass(frozen=True, slots=True)
class PropertyShare:
    """Shares of texts that show a linguistic property, 0 to 1.

    Attributes:
        instructions: share of single instructions.
        episodes: share of episodes with at least one such instruction, as in the paper's table.
    """

    instructions: float
    episodes: float


@dataclass(frozen=True, eq=False)
class PhaseStatistics:
    """Statistics of one phase's instructions.

    Attributes:
        lengths: of instructions and ground truths.
        frequent: the most frequent words and their counts, without stop words and names of collectibles.
        properties: by name, see `arramon_dataset.statistics.properties`.
        diversity: of a sample of the instructions; None if fewer than two have words.
    """

    lengths: PhaseLengths
    frequent: tuple[tuple[str, int], ...]
    properties: dict[str, PropertyShare]
    diversity: Diversity | None


@dataclass(frozen=True, eq=False)
class SplitStatistics:
    """Statistics of a split's instructions in one language.

    Attributes:
        split: name of the split.
        language: code of the language.
        episodes: number of episodes in this language.
        lacking: number of the split's episodes without this language.
        preview: whether the language is published for trial, before native speakers have reviewed it.
        phases: statistics by phase.
    """

    split: str
    language: str
    episodes: int
    lacking: int
    preview: bool
    phases: dict[str, PhaseStatistics]


def measure(
    split: str,
    episodes: Sequence[Episode],
    code: str,
    *,
    lacking: int = 0,
    sample: int | None = SAMPLE,
    seed: int = 0,
) -> SplitStatistics:
    """Measure the instructions of episodes in one language.

    Args:
        split: name of the split.
        episodes: at least one, each with instructions in the language.
        code: of the language.
        lacking: number of the split's episodes without this language.
        sample: number of instructions of a phase sampled for the diversity; None for all.
        seed: of the sample.

    Raises:
        NotFound: if the language does not exist.
        BadFile: if its patterns are invalid.
    """
    try:
        language = load(code)
    except UnknownLanguage as error:
        raise NotFound(str(error)) from error
    phases = {phase: _measure_phase(episodes, phase, language, sample, seed) for phase in PHASES}
    return SplitStatistics(split, code, len(episodes), lacking, language.preview, phases)


def _measure_phase(
    episodes: Sequence[Episode], phase: str, language: Language, sample: int | None, seed: int
) -> PhaseStatistics:
    texts = [episode.instruction(language.code, turn, phase) for episode in episodes for turn in (1, 2)]
    words = [words_of(language, text) for text in texts]
    spoken = [each for each in words if each]
    return PhaseStatistics(
        lengths=lengths_of(episodes, phase, words),
        frequent=_frequent(texts, language),
        properties=_properties(words, language),
        diversity=diversity(spoken, sample=sample, seed=seed) if len(spoken) > 1 else None,
    )


def _frequent(texts: Sequence[str], language: Language) -> tuple[tuple[str, int], ...]:
    stopwords = load_patterns(language.code).stopwords
    counts: Counter[str] = Counter()
    for text in texts:
        counts.update(words_of(language, _without(text, language.find_objects(text))))
    for word in stopwords:
        del counts[word]
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(ordered[:FREQUENT])


def _without(text: str, mentions: Sequence[Mention]) -> str:
    """Return the text with each mention replaced by a comma."""
    cuts = [0, *(place for mention in mentions for place in (mention.start, mention.end)), len(text)]
    return " , ".join(text[start:end] for start, end in list(pairwise(cuts))[::2])


def _properties(words: Sequence[Sequence[str]], language: Language) -> dict[str, PropertyShare]:
    patterns = load_patterns(language.code)
    found = [patterns.find(each) for each in words]
    shares = {}
    for name in PROPERTIES:
        shown = [name in each for each in found]
        both = [first or second for first, second in zip(shown[::2], shown[1::2], strict=True)]
        shares[name] = PropertyShare(sum(shown) / len(shown), sum(both) / len(both))
    return shares
