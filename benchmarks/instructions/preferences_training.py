"""Training of a language's preferences among drafts: `python -m benchmarks.instructions.preferences_training DATA`.

The writer draws several drafts of a text, and one of them by the odds that people write such word sequences
(`lang/writing/preferences.py`). The weights are those of a conditional maximum-entropy model: with them, the expected
share of the drawn texts that contain a sequence is people's share, as far as the drafts and a penalty allow. So nothing
is written more often than people write it, and what they seldom write stays. The drafts are of the meanings of a
generated data set; people's texts are those of the official release's val-seen file, whose folder ARRAMON_RELEASE
names.

The file that is written has weights of sequences of function words, verbs and marks, each in at least `MIN_TEXTS`
texts. It contains no text of the release, and no name of a thing.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize
from scipy.sparse import csr_matrix
from sklearn.feature_extraction.text import CountVectorizer

import arramon_lang as lang
from arramon_dataset.randomness import seeded
from arramon_lang.files import read_file
from arramon_lang.language import ROOT
from arramon_lang.meaning import Meaning
from arramon_lang.writing.preferences import LONGEST, reduced
from arramon_lang.writing.writer import PREFERRED_DRAFTS, Writer
from benchmarks.common import parser_of
from benchmarks.instructions.distinguish import PHASES, compared_texts, generated_texts
from benchmarks.instructions.masking import masked_words

MIN_TEXTS = 10
"""Minimum number of texts that contain a word, and a sequence of words."""

PENALTY = 0.004
"""Weight of the squared sum of weights, per text."""

MAX_ITERATIONS = 150

LEAST = 0.05
"""Weights below this are left out of the file."""

LANGUAGE = "en"

Floats = npt.NDArray[np.float64]
Drafts = Sequence[tuple[list[str], list[float]]]
"""For each text its drafts, and their log-odds without preferences."""


def train(drafts: Drafts, theirs: Sequence[str]) -> dict[str, float]:
    """Return the weights of word sequences with which drawn drafts contain each as often as people's texts do."""
    texts = [draft for each, _ in drafts for draft in each]
    either = (*theirs, *(each[0] for each, _ in drafts))
    ngrams = CountVectorizer(analyzer=_Analyzer(frequent_words(either)), min_df=MIN_TEXTS, binary=True).fit(either)
    people = np.asarray(ngrams.transform(theirs).mean(axis=0)).ravel()
    contained = csr_matrix(ngrams.transform(texts), dtype=np.float64)
    base = np.array([odds for _, each in drafts for odds in each])
    starts = np.cumsum([0, *(len(each) for each, _ in drafts)])[:-1]
    weights = _fitted(contained, base, starts, people)
    return dict(zip(map(str, ngrams.get_feature_names_out()), weights.tolist(), strict=True))


def _fitted(contained: csr_matrix, base: Floats, starts: npt.NDArray[np.int64], people: Floats) -> Floats:
    """Return the weights at which the expected share of drawn drafts with each sequence is `people`'s.

    Args:
        contained: (drafts, sequences), 1 where a draft contains a sequence.
        base: (drafts,), log-odds without preferences.
        starts: (texts,), index of each text's first draft.
        people: (sequences,), share of people's texts that contain each sequence.
    """
    sizes = np.diff([*starts, len(base)])

    def loss(weights: Floats) -> tuple[float, Floats]:
        odds = base + contained @ weights
        best = np.maximum.reduceat(odds, starts)
        shares = np.exp(odds - np.repeat(best, sizes))
        totals = np.add.reduceat(shares, starts)
        shares /= np.repeat(totals, sizes) * len(starts)
        value = float(np.mean(best + np.log(totals)) - weights @ people + PENALTY * (weights @ weights))
        return value, contained.T @ shares - people + 2 * PENALTY * weights

    found = minimize(
        loss, np.zeros(contained.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": MAX_ITERATIONS}
    )
    return np.asarray(found.x, dtype=np.float64)


class _Analyzer:
    """Word sequences of a text with these words."""

    def __init__(self, kept: set[str]) -> None:
        self._kept = kept

    def __call__(self, text: str) -> list[str]:
        words = reduced(text, self._kept)
        return [" ".join(words[at : at + n]) for n in range(1, LONGEST + 1) for at in range(len(words) - n + 1)]


def frequent_words(texts: Iterable[str]) -> set[str]:
    """Return the words in at least MIN_TEXTS texts that name nothing."""
    counts = Counter(word for text in texts for word in {*masked_words(text, LANGUAGE).split()})
    return {word for word, count in counts.items() if count >= MIN_TEXTS and not word.isupper()} - {"<", ">"}


def drafts_of(meanings: Sequence[Sequence[Meaning]], phase: str) -> Drafts:
    """Return drafts of each meaning; one voice writes those of an episode."""
    language, found = lang.load(LANGUAGE), []
    writer = Writer(language.grammar)
    for number, episode in enumerate(meanings):
        voice = language.draw_voice(seeded(number))
        for at, each in enumerate(episode):
            drafts = writer.drafts(each, seeded(number, at), voice, PREFERRED_DRAFTS[phase])
            found.append((drafts, [-voice.manner.brevity * len(draft.split()) for draft in drafts]))
    return found


def main(argv: Sequence[str] | None = None) -> int:
    """Train the phases and write the file; return the exit status."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`, of a seed for training only")
    parser.add_argument(
        "--phases", nargs="+", choices=PHASES, default=[*PHASES], help="train these, and keep the others' weights"
    )
    arguments = parser.parse_args(argv)
    language, lines, kept = lang.load(LANGUAGE), [_HEADER], read_file(ROOT / LANGUAGE, "preferences")
    for phase in PHASES:
        weights = kept[phase]
        if phase in arguments.phases:
            theirs = [text for episode in compared_texts(LANGUAGE, phase) for text in episode]
            episodes = generated_texts(arguments.data, LANGUAGE, phase)
            meanings = [[language.read(text, phase) for text in episode] for episode in episodes]
            weights = train(drafts_of(meanings, phase), theirs)
        listed = sorted((key, weight) for key, weight in weights.items() if abs(weight) >= LEAST)
        lines += [f"\n[{phase}]", *(f"{_quoted(key)} = {weight:.2f}" for key, weight in listed)]
    path = ROOT / LANGUAGE / "preferences.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(path)
    return 0


_HEADER = """\
# Weights of word sequences, by which the writer draws one of several drafts: log-odds that people rather than the
# grammar write them. "<" and ">" are a text's beginning and end, "_" stands for one or more other words, such as names
# of things.
#
# Learnt by `python -m benchmarks.instructions.preferences_training` from the official release's val-seen texts (MIT
# licence, Copyright (c) 2020 hyounghk). Contains no text: sequences of up to three function words, verbs and marks,
# each of which occurs in at least 10 texts. Not to be edited by hand."""


def _quoted(key: str) -> str:
    return '"' + key.replace("\\", "\\\\").replace('"', '\\"') + '"'


if __name__ == "__main__":
    sys.exit(main())
