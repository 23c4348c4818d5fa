"""Diversity of texts: MTLD, distinct-n, self-BLEU and zlib ratio. A text is a sequence of words.

All measures depend on the amount of text: compare texts on samples of equal size.
"""

import math
import zlib
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from arramon_dataset.randomness import seeded

SAMPLE = 2000
"""Default number of texts to measure."""

MTLD_THRESHOLD = 0.72
"""The type-token ratio at which a factor is complete (McCarthy and Jarvis 2010)."""

BLEU_ORDER = 4

GROUP = 300
"""Approximate number of texts compared with each other in self-BLEU, which grows with the number of references."""

BLEU_EPSILON = 0.1
"""Replaces a zero count of matching n-grams (method 1 of Chen and Cherry 2014)."""

Words = Sequence[str]
Gram = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Diversity:
    """Diversity measures of a sample of texts.

    Attributes:
        texts: number of texts measured.
        tokens: number of words in them.
        types: number of distinct words in them.
        mtld: measure of textual lexical diversity of the concatenated texts, mean of both directions; higher is more
            varied.
        distinct: share of distinct n-grams among those within texts, for n = 1, 2, 3; higher is more varied.
        self_bleu: mean BLEU-4 of each text against the others of a random group of about 300, 0 to 100; lower is more
            varied.
        self_bleu_all: the same against all others of the sample.
        zlib_ratio: size of the texts over their compressed size; lower is more varied.
        different: share of distinct texts, 0 to 1.
    """

    texts: int
    tokens: int
    types: int
    mtld: float
    distinct: tuple[float, float, float]
    self_bleu: float
    self_bleu_all: float
    zlib_ratio: float
    different: float


def diversity(texts: Sequence[Words], *, sample: int | None = SAMPLE, seed: int = 0) -> Diversity:
    """Measure the diversity of texts, or of a random sample of them.

    Args:
        texts: words of each text, normalised for comparison (one case, no punctuation: see
            `arramon_dataset.statistics.words`).
        sample: maximum number of texts, drawn without replacement; None for all. Their order is kept, as MTLD and
            compression depend on it: the turns of one episode are more alike than two random turns.
        seed: of the sample.

    Raises:
        ValueError: if there are fewer than two texts, or one has no words.
    """
    if len(texts) < 2 or not all(texts):
        raise ValueError("diversity needs at least two texts, each with at least one word")
    if sample is not None:
        drawn = seeded("diversity", seed).sample(range(len(texts)), min(sample, len(texts)))
        texts = [texts[number] for number in sorted(drawn)]
    words = [word for text in texts for word in text]
    return Diversity(
        texts=len(texts),
        tokens=len(words),
        types=len(set(words)),
        mtld=mtld(words),
        distinct=(distinct(texts, 1), distinct(texts, 2), distinct(texts, 3)),
        self_bleu=_grouped_self_bleu(texts, seed),
        self_bleu_all=self_bleu(texts),
        zlib_ratio=zlib_ratio(texts),
        different=len({tuple(text) for text in texts}) / len(texts),
    )


def mtld(words: Words, threshold: float = MTLD_THRESHOLD) -> float:
    """Return the MTLD: the mean length of word sequences that keep a type-token ratio above `threshold`.

    McCarthy and Jarvis 2010: a segment ends with the word that takes the ratio to the threshold or below; an incomplete
    last segment counts as the fraction by which its ratio has fallen. Forward and backward passes are averaged.

    Raises:
        ValueError: if there are no words.
    """
    if not words:
        raise ValueError("the MTLD of an empty text is undefined")
    return (_mtld_one_way(words, threshold) + _mtld_one_way(words[::-1], threshold)) / 2


def _mtld_one_way(words: Words, threshold: float) -> float:
    factors = 0.0
    types: set[str] = set()
    count = 0
    for word in words:
        types.add(word)
        count += 1
        if len(types) / count <= threshold:
            factors += 1
            types, count = set(), 0
    if count:
        factors += (1 - len(types) / count) / (1 - threshold)
    return len(words) / factors if factors else float(len(words))  # No word occurs twice: one incomplete segment.


def distinct(texts: Iterable[Words], n: int) -> float:
    """Return the share of distinct n-grams among all within the texts, 0 to 1; 0 if there are none (Li et al. 2016)."""
    counts = Counter(gram for text in texts for gram in _grams(text, n))
    total = counts.total()
    return len(counts) / total if total else 0.0


def self_bleu(texts: Sequence[Words]) -> float:
    """Return the mean BLEU-4 of each text with all other texts as its references, 0 to 100 (Zhu et al. 2018).

    Sentence BLEU with equal weights for n = 1 to 4, brevity penalty by the closest reference's length, and zero counts
    replaced by 0.1; orders longer than a text are left out. Runs in linear time: an n-gram's count is clipped by its
    highest count in any other text, for which the two highest counts of each n-gram suffice.

    Raises:
        ValueError: if there are fewer than two texts, or one has no words.
    """
    if len(texts) < 2 or not all(texts):
        raise ValueError("self-BLEU needs at least two texts, each with at least one word")
    logs = [0.0] * len(texts)
    for n in range(1, BLEU_ORDER + 1):
        counts = [Counter(_grams(text, n)) for text in texts]
        for number, precision in enumerate(_clipped_precisions(counts)):
            orders = min(BLEU_ORDER, len(texts[number]))
            logs[number] += math.log(precision) / orders if precision else 0.0
    lengths = sorted(len(text) for text in texts)
    scores = [math.exp(log) * _brevity_penalty(len(text), lengths) for log, text in zip(logs, texts, strict=True)]
    return 100 * sum(scores) / len(scores)


def _grouped_self_bleu(texts: Sequence[Words], seed: int) -> float:
    """Return the mean over random groups of about `GROUP` texts, whose sizes differ by at most one."""
    shuffled = seeded("self-BLEU", seed).sample(list(texts), len(texts))
    groups = max(1, round(len(texts) / GROUP))
    scores = [(self_bleu(group), len(group)) for group in (shuffled[start::groups] for start in range(groups))]
    return sum(score * size for score, size in scores) / len(texts)


def _clipped_precisions(counts: Sequence[Counter[Gram]]) -> Iterator[float]:
    """Yield for each text the share of its n-grams found in other texts; 0 for a text without n-grams."""
    most: dict[Gram, int] = {}
    next_most: dict[Gram, int] = {}  # Equal to `most` where two texts share the highest count.
    for counter in counts:
        for gram, count in counter.items():
            highest = most.get(gram, 0)
            if count >= highest:
                most[gram], next_most[gram] = count, highest
            elif count > next_most[gram]:
                next_most[gram] = count
    for counter in counts:
        matching = 0
        for gram, count in counter.items():
            elsewhere = next_most[gram] if count == most[gram] else most[gram]
            matching += min(count, elsewhere)
        total = counter.total()
        yield (matching or BLEU_EPSILON) / total if total else 0.0


def _brevity_penalty(length: int, lengths: Sequence[int]) -> float:
    """Return BLEU's brevity penalty for a text whose own length is in the sorted `lengths`; ties favour the shorter."""
    place = bisect_left(lengths, length)
    if place + 1 < len(lengths) and lengths[place + 1] == length:
        return 1.0
    if place > 0 and (place + 1 == len(lengths) or length - lengths[place - 1] <= lengths[place + 1] - length):
        return 1.0  # The closest length is shorter.
    return math.exp(1 - lengths[place + 1] / length)


def zlib_ratio(texts: Iterable[Words]) -> float:
    """Return the texts' size over their size compressed by zlib at level 9: one text per line, words with spaces.

    Every script gets the same number of bytes per character, one for up to 256 distinct characters and two for more, so
    that languages are comparable: UTF-8 uses three bytes for Devanagari letters and one for Latin ones.
    """
    text = "\n".join(" ".join(words) for words in texts)
    numbers = {character: number for number, character in enumerate(sorted(set(text)))}
    width = 1 if len(numbers) <= 256 else 2
    data = b"".join(numbers[character].to_bytes(width, "big") for character in text)
    return len(data) / len(zlib.compress(data, 9))


def _grams(words: Words, n: int) -> Iterator[Gram]:
    return (tuple(words[start : start + n]) for start in range(len(words) - n + 1))
