"""How varied texts are: MTLD, distinct-n, self-BLEU, zlib ratio. Knows words only; whoever asks has split the texts.

All of these depend on how much text there is, so texts are compared on samples of equal size.
"""

import math
import zlib
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from server.episodes.chance import seeded

SAMPLE = 2000
"""Texts that are measured where nothing else is asked for."""

MTLD_THRESHOLD = 0.72
"""The type-token ratio at which a factor is full (McCarthy and Jarvis 2010)."""

BLEU_ORDER = 4

GROUP = 300
"""Texts of about which number stand against each other in self-BLEU: it grows with how many references there are."""

BLEU_EPSILON = 0.1
"""Stands for a count of matching n-grams that is zero (method 1 of Chen and Cherry 2014)."""

Words = Sequence[str]
Gram = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Diversity:
    """How varied a sample of texts is.

    Attributes:
        texts: how many were measured.
        tokens: words in them.
        types: different words in them.
        mtld: measure of textual lexical diversity, of the texts in a row, mean of both directions; more is more varied.
        distinct: share of different ones among the n-grams within texts, for n = 1, 2, 3; more is more varied.
        self_bleu: mean BLEU-4 of each text against the others of a random group of about 300, 0 to 100; less is more
            varied.
        self_bleu_all: the same against all others of the sample.
        zlib_ratio: size of the texts over their compressed size; less is more varied.
        different: share of different ones among the texts, 0 to 1.
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
    """Measures texts, or a sample of them.

    Args:
        texts: each one's words, as they are to be compared (in one case, without marks: see `server.stats.words`).
        sample: how many to draw at most, without putting back; None for all. They stay in their order, which the MTLD
            and the compression see: the turns of an episode are more alike than two of anywhere.
        seed: of the draws.

    Raises:
        ValueError: if there are fewer than two texts, or one without words.
    """
    if len(texts) < 2 or not all(texts):
        raise ValueError("diversity needs two texts at least, each with a word at least")
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
    """Measure of textual lexical diversity: the mean length of stretches of a type-token ratio above `threshold`.

    McCarthy and Jarvis 2010: a stretch ends with the word that takes the ratio to the threshold or below; what is left
    at the end counts as the part of a stretch that it has come down. The mean of reading forwards and backwards.

    Raises:
        ValueError: if there are no words.
    """
    if not words:
        raise ValueError("the MTLD of no words is not defined")
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
    return len(words) / factors if factors else float(len(words))  # No word comes twice: one stretch, not yet over.


def distinct(texts: Iterable[Words], n: int) -> float:
    """Share of different n-grams among all within the texts, 0 to 1; 0 where none is that long (Li et al. 2016)."""
    counts = Counter(gram for text in texts for gram in _grams(text, n))
    total = counts.total()
    return len(counts) / total if total else 0.0


def self_bleu(texts: Sequence[Words]) -> float:
    """Mean over the texts of the BLEU-4 of each against all others as its references, 0 to 100 (Zhu et al. 2018).

    Sentence BLEU with equal weights for n = 1 to 4, brevity penalty by the closest reference's length, and counts of
    zero taken as 0.1; orders that a text is too short for are left out. Takes time in proportion to the texts' length:
    what clips a text's n-gram is its highest count anywhere else, and for that two counts for each n-gram are enough.

    Raises:
        ValueError: if there are fewer than two texts, or one without words.
    """
    if len(texts) < 2 or not all(texts):
        raise ValueError("self-BLEU needs two texts at least, each with a word at least")
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
    """The mean over random groups of about `GROUP` texts, all of the same size or one more."""
    shuffled = seeded("self-BLEU", seed).sample(list(texts), len(texts))
    groups = max(1, round(len(texts) / GROUP))
    scores = [(self_bleu(group), len(group)) for group in (shuffled[start::groups] for start in range(groups))]
    return sum(score * size for score, size in scores) / len(texts)


def _clipped_precisions(counts: Sequence[Counter[Gram]]) -> Iterator[float]:
    """For each text the share of its n-grams found elsewhere; 0 where it has none."""
    most: dict[Gram, int] = {}
    next_most: dict[Gram, int] = {}  # The same as `most` where two texts share it.
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
    """BLEU's for a text whose own length is among the sorted `lengths`; of equally close ones the shorter counts."""
    place = bisect_left(lengths, length)
    if place + 1 < len(lengths) and lengths[place + 1] == length:
        return 1.0
    if place > 0 and (place + 1 == len(lengths) or length - lengths[place - 1] <= lengths[place + 1] - length):
        return 1.0  # The closest one is shorter.
    return math.exp(1 - lengths[place + 1] / length)


def zlib_ratio(texts: Iterable[Words]) -> float:
    """Size of the texts over their size compressed by zlib at level 9: a line a text, its words with spaces between.

    Every script gets as many bytes a character, one up to 256 different characters and two beyond, so that languages
    compare: in UTF-8, Devanagari takes three bytes a character where Latin takes one.
    """
    text = "\n".join(" ".join(words) for words in texts)
    numbers = {character: number for number, character in enumerate(sorted(set(text)))}
    width = 1 if len(numbers) <= 256 else 2
    data = b"".join(numbers[character].to_bytes(width, "big") for character in text)
    return len(data) / len(zlib.compress(data, 9))


def _grams(words: Words, n: int) -> Iterator[Gram]:
    return (tuple(words[start : start + n]) for start in range(len(words) - n + 1))
