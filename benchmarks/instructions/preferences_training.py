"""Training of a language's preferences among drafts: `python -m benchmarks.instructions.preferences_training DATA`.

The writer draws several drafts of a text, and one of them by the odds that people write such word sequences
(`lang/writing/preferences.py`). The weights are learnt in rounds: the texts of a generated data set are read and
written anew with the weights so far; a logistic regression tells them from those of the official release's val-seen
file, whose folder ARRAMON_RELEASE names; its weights are added. When it can no longer tell them apart, the writer uses
each sequence as often as people do, as far as its drafts and plans allow.

The file that is written has weights of sequences of function words, verbs and marks, each in at least `MIN_TEXTS`
texts. It contains no text of the release, and no name of a thing.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from sklearn.feature_extraction.text import CountVectorizer
from sklearn.linear_model import LogisticRegression

import arramon_lang as lang
from arramon_dataset.randomness import seeded
from arramon_lang.language import ROOT
from arramon_lang.meaning import Meaning
from arramon_lang.writing.preferences import LONGEST, Preferences, reduced
from arramon_lang.writing.writer import Writer
from benchmarks.common import parser_of, positive_int
from benchmarks.instructions.distinguish import PHASES, compared_texts, generated_texts
from benchmarks.instructions.masking import masked_words

MIN_TEXTS = 20
"""Minimum number of texts that contain a word, and a sequence of words."""

STRENGTH = 0.05
"""Inverse strength of each round's L2 penalty."""

STEP = 0.8
"""Share of a round's weights that is added."""

LEAST = 0.05
"""Weights below this are left out of the file."""

LANGUAGE = "en"


def train(meanings: Sequence[Sequence[Meaning]], theirs: Sequence[str], phase: str, rounds: int) -> dict[str, float]:
    """Return the weights of word sequences for one phase.

    Args:
        meanings: by episode; one voice writes those of an episode.
        theirs: people's texts.
        phase: "navigation" or "assembly".
        rounds: number of rounds.
    """
    weights: dict[str, float] = {}
    for number in range(rounds):
        ours = written(meanings, phase, weights, number)
        kept = frequent_words((*theirs, *ours))
        ngrams = CountVectorizer(analyzer=_Analyzer(kept), min_df=MIN_TEXTS, binary=True)
        found = ngrams.fit_transform((*theirs, *ours))
        sides = [True] * len(theirs) + [False] * len(ours)
        model = LogisticRegression(C=STRENGTH, max_iter=2000, class_weight="balanced").fit(found, sides)
        print(f"{phase}, round {number + 1}: {model.score(found, sides):.3f} of the texts are told apart", flush=True)
        for name, weight in zip(ngrams.get_feature_names_out(), model.coef_[0], strict=True):
            weights[name] = weights.get(name, 0.0) + STEP * float(weight)
    return weights


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


def written(meanings: Sequence[Sequence[Meaning]], phase: str, weights: dict[str, float], seed: int) -> list[str]:
    """Return a text for each meaning, written with these weights."""
    writer, language = Writer(lang.load(LANGUAGE).grammar, Preferences({phase: weights})), lang.load(LANGUAGE)
    texts = []
    for number, episode in enumerate(meanings):
        voice = language.draw_voice(seeded(seed, number))
        texts += [writer.write(each, seeded(seed, number, at), voice) for at, each in enumerate(episode)]
    return texts


def main(argv: Sequence[str] | None = None) -> int:
    """Train both phases and write the file; return the exit status."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`, of a seed for training only")
    parser.add_argument("--rounds", type=positive_int, default=8, metavar="N", help="rounds (default: %(default)s)")
    arguments = parser.parse_args(argv)
    language, lines = lang.load(LANGUAGE), [_HEADER]
    for phase in PHASES:
        theirs = [text for episode in compared_texts(LANGUAGE, phase) for text in episode]
        episodes = generated_texts(arguments.data, LANGUAGE, phase)
        meanings = [[language.read(text, phase) for text in episode] for episode in episodes]
        weights = train(meanings, theirs, phase, arguments.rounds)
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
# each of which occurs in at least 20 texts. Not to be edited by hand."""


def _quoted(key: str) -> str:
    return '"' + key.replace("\\", "\\\\").replace('"', '\\"') + '"'


if __name__ == "__main__":
    sys.exit(main())
