"""Everything that is measured of one split in one language."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from lang import Language, Mention, UnknownLanguage, load
from server.episodes.episode import Episode
from server.errors import NotFound
from server.stats.diversity import SAMPLE, Diversity, diversity
from server.stats.lengths import PhaseLengths, lengths_of
from server.stats.properties import PROPERTIES, load_patterns
from server.stats.words import words_of

PHASES = ("navigation", "assembly")

FREQUENT = 25
"""Most frequent words that are told, as in the paper's figure."""


@dataclass(frozen=True, slots=True)
class Share:
    """How many show a linguistic property, 0 to 1.

    Attributes:
        instructions: of single instructions.
        episodes: of episodes, either of whose instructions counts, as in the paper's table.
    """

    instructions: float
    episodes: float


@dataclass(frozen=True, eq=False)
class PhaseFigures:
    """What one phase's instructions are like.

    Attributes:
        lengths: of instructions and ground truths.
        frequent: the most frequent words and how often they occur; without stop words and the names of collectibles.
        properties: by name, see `server.stats.properties`.
        diversity: of a sample of the instructions; None where there are no two.
    """

    lengths: PhaseLengths
    frequent: tuple[tuple[str, int], ...]
    properties: dict[str, Share]
    diversity: Diversity | None


@dataclass(frozen=True, eq=False)
class Figures:
    """What a split's instructions in one language are like.

    Attributes:
        split: its name.
        language: the code.
        episodes: how many hold this language.
        phases: by name.
    """

    split: str
    language: str
    episodes: int
    phases: dict[str, PhaseFigures]


def measure(
    split: str, episodes: Sequence[Episode], code: str, *, sample: int | None = SAMPLE, seed: int = 0
) -> Figures:
    """Measures episodes that all hold the language.

    Args:
        split: what they are called.
        episodes: one at least.
        code: of the language.
        sample: instructions of a phase to draw for the diversity; None for all.
        seed: of that draw.

    Raises:
        NotFound: if there is no such language.
        BadFile: if its patterns are wrong.
    """
    try:
        language = load(code)
    except UnknownLanguage as error:
        raise NotFound(str(error)) from error
    phases = {phase: _measure_phase(episodes, phase, language, sample, seed) for phase in PHASES}
    return Figures(split, code, len(episodes), phases)


def _measure_phase(
    episodes: Sequence[Episode], phase: str, language: Language, sample: int | None, seed: int
) -> PhaseFigures:
    texts = [episode.instruction(language.code, turn, phase) for episode in episodes for turn in (1, 2)]
    words = [words_of(language, text) for text in texts]
    spoken = [each for each in words if each]
    return PhaseFigures(
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
    """The text with a mark in place of each mention."""
    cuts = [0, *(place for mention in mentions for place in (mention.start, mention.end)), len(text)]
    return " , ".join(text[start:end] for start, end in list(pairwise(cuts))[::2])


def _properties(words: Sequence[Sequence[str]], language: Language) -> dict[str, Share]:
    patterns = load_patterns(language.code)
    found = [patterns.found(each) for each in words]
    shares = {}
    for name in PROPERTIES:
        shown = [name in each for each in found]
        both = [first or second for first, second in zip(shown[::2], shown[1::2], strict=True)]
        shares[name] = Share(sum(shown) / len(shown), sum(both) / len(both))
    return shares
