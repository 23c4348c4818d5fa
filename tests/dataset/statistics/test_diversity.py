"""Measures of diversity, compared with hand-computed values and a plain self-BLEU."""

import json
import math
from collections import Counter
from random import Random

import pytest

from arramon_dataset.statistics.diversity import distinct, diversity, mtld, self_bleu, zlib_ratio
from arramon_dataset.statistics.words import words_of
from arramon_lang import load
from tests.release import VAL_SEEN, needs_release


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a b c d e", 5.0),  # Nothing twice: one stretch that never ends.
        ("a a", 2.0),  # 1/2 is below 0.72: one full factor in two words.
        ("a b a", 3.0),  # 2/3 likewise.
        ("a b a c d c", 3.0),
        ("a b c a", 4.48),  # 3/4 is above: (1 - 0.75) / (1 - 0.72) of a factor in four words.
        ("a a b c", 4.24),  # 4 forwards, 4.48 backwards.
    ],
)
def test_mtld_matches_hand_computed_values(text: str, value: float) -> None:
    assert mtld(text.split()) == pytest.approx(value)


@pytest.mark.parametrize(("n", "value"), [(1, 2 / 6), (2, 2 / 4), (3, 1.0), (5, 0.0)])
def test_distinct_counts_within_texts(n: int, value: float) -> None:
    assert distinct([["a", "b", "a", "b"], ["a", "b"]], n) == pytest.approx(value)


@pytest.mark.parametrize(
    ("texts", "value"),
    [
        (["a b c d", "a b c d"], 100.0),
        (["a b", "a b", "a b"], 100.0),  # Too short for orders 3 and 4.
        (["a b c d", "a b c e"], 100 * (3 / 4 * 2 / 3 * 1 / 2 * 0.1) ** (1 / 4)),
        (["a a", "a b"], 100 * (1 / 2 * 0.1) ** (1 / 2)),  # The second "a" of "a a" has no match, nor has a bigram.
        (["a b c d e f", "a b c d"], 50 * ((4 / 6 * 3 / 5 * 2 / 4 * 1 / 3) ** (1 / 4) + math.exp(1 - 6 / 4))),
    ],
)
def test_self_bleu_matches_hand_computed_values(texts: list[str], value: float) -> None:
    assert self_bleu([text.split() for text in texts]) == pytest.approx(value)


def plain_self_bleu(texts: list[list[str]]) -> float:
    """As the definition has it, each text against each other."""
    scores = []
    for number, text in enumerate(texts):
        others = texts[:number] + texts[number + 1 :]
        orders = range(1, min(4, len(text)) + 1)
        log = 0.0
        for n in orders:
            counts = Counter(zip(*(text[k:] for k in range(n)), strict=False))
            elsewhere = [Counter(zip(*(other[k:] for k in range(n)), strict=False)) for other in others]
            matching = sum(min(count, max(other[gram] for other in elsewhere)) for gram, count in counts.items())
            log += math.log((matching or 0.1) / counts.total()) / len(orders)
        closest = min((abs(len(other) - len(text)), len(other)) for other in others)[1]
        scores.append(math.exp(log) * min(1.0, math.exp(1 - closest / len(text))))
    return 100 * sum(scores) / len(scores)


def test_self_bleu_equals_a_plain_implementation() -> None:
    random = Random(1)
    for _ in range(20):
        texts = [random.choices("abcde", k=random.randint(1, 12)) for _ in range(random.randint(2, 12))]
        assert self_bleu(texts) == pytest.approx(plain_self_bleu(texts))


def test_zlib_ratio_is_the_same_in_every_script() -> None:
    latin = [random.choices(["abc", "de", "f"], k=30) for random in map(Random, range(9))]
    devanagari = [[word.translate(dict(zip(b"abcdef", "कखगघचछ", strict=True))) for word in text] for text in latin]
    assert zlib_ratio(latin) == zlib_ratio(devanagari)
    assert zlib_ratio([["abc"] * 1000]) > 100 > zlib_ratio(latin) > 2


def test_samples_are_reproducible_and_depend_on_the_seed() -> None:
    texts = [Random(number).choices("abcdefgh", k=9) for number in range(40)]
    assert diversity(texts, sample=20) == diversity(texts, sample=20) != diversity(texts, sample=20, seed=1)
    whole = diversity(texts, sample=None)
    assert whole == diversity(texts, sample=99)
    assert (whole.texts, whole.tokens, whole.types, whole.different) == (40, 360, 8, 1.0)
    assert whole.mtld == mtld([word for text in texts for word in text])
    assert whole.self_bleu == pytest.approx(whole.self_bleu_all)  # One group.


@pytest.mark.parametrize("texts", [[], [["a"]], [["a"], []]])
def test_fewer_than_two_nonempty_texts_is_an_error(texts: list[list[str]]) -> None:
    with pytest.raises(ValueError, match="at least two texts"):
        diversity(texts)


@needs_release
@pytest.mark.parametrize(
    ("phase", "types", "tokens", "lexical", "bigrams", "trigrams"),
    [("navi_inst_gt", 882, 70452, 34.6, 0.086, 0.251), ("assem_inst_gt", 384, 32316, 22.8, 0.064, 0.173)],
)
def test_diversity_of_the_official_release_matches_known_values(
    phase: str, types: int, tokens: int, lexical: float, bigrams: float, trigrams: float
) -> None:
    """Known values, counted with words of a to z and apostrophes only; here numbers are words too."""
    records = json.loads(VAL_SEEN.read_text())
    texts = [words_of(load("en"), text) for record in records for text in record["instructions"][phase]]
    found = diversity(texts, sample=None)
    assert found.types == pytest.approx(types, abs=7)
    assert found.tokens == pytest.approx(tokens, abs=23)
    assert found.mtld == pytest.approx(lexical, abs=0.051)
    assert found.distinct[1:] == pytest.approx((bigrams, trigrams), abs=0.001)
    assert found.self_bleu < found.self_bleu_all
