"""How well generated texts can be told from people's: `python -m benchmarks.instructions.distinguish DATA`.

A logistic regression over masked n-grams (`masking.py`), of words alone and with marks and kinds of things, learns to
tell the texts of a generated data set from those of the official release's val-seen file, whose folder the environment
variable ARRAMON_RELEASE names. Its accuracy on episodes that it has not seen is 0.5 if they cannot be told apart. Both
sides have the same number of texts. As a control, it also learns to tell two random halves of people's episodes apart.

There are no people's texts in Hindi. `--lang hi` compares with the free paraphrases (`dataset/paraphrases/data`), which
a language model wrote: it shows what distinguishes the grammar from that model's ten manners, not from people.
"""

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sklearn.feature_extraction.text import CountVectorizer
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import GroupKFold

from arramon_dataset.paraphrases.collection import paraphrases
from arramon_dataset.randomness import seeded
from benchmarks.common import parser_of, positive_int, text_table
from benchmarks.instructions.masking import masked_words

PHASES = {"navigation": "navi_inst_gt", "assembly": "assem_inst_gt"}
"""Phases, with the keys of their texts in the release."""

MIN_TEXTS = 20
"""Minimum number of texts that contain an n-gram: rarer ones do not count."""

LONGEST = 3
"""Maximum number of words of an n-gram."""

FOLDS = 10

STRENGTH = 0.3
"""Inverse strength of the regression's L2 penalty."""

RESAMPLES = 1000
"""Number of bootstrap samples of episodes for the interval of the accuracy."""

Texts = Sequence[Sequence[str]]
"""Texts by episode."""


@dataclass(frozen=True, slots=True)
class Distinction:
    """How well two sets of texts are told apart.

    Attributes:
        accuracy: share of texts assigned to their set, by a model that has not seen their episodes.
        interval: its 95% interval, over episodes.
        texts: number of texts on each side.
        first: n-grams that speak for the first set, the strongest first, each with its share of both sets' texts.
        second: the same for the second set.
    """

    accuracy: float
    interval: tuple[float, float]
    texts: int
    first: list[tuple[str, float, float]]
    second: list[tuple[str, float, float]]


def distinguish(first: Texts, second: Texts, language: str, *, is_coarse: bool = True, seed: int = 1) -> Distinction:
    """Return how well two sets of texts, cut to equal numbers of episodes, are told apart.

    Args:
        first, second: the texts.
        language: "en" or "hi".
        is_coarse: whether punctuation, and kinds of things, do not count.
        seed: of episodes and folds.

    Raises:
        ValueError: if a side has fewer episodes than there are folds.
    """
    random = seeded("distinguish", seed)
    count = min(len(first), len(second))
    if count < FOLDS:
        raise ValueError(f"{count} episodes; expected at least {FOLDS} on each side")
    chosen = [*random.sample(list(first), count), *random.sample(list(second), count)]
    texts = [masked_words(text, language, is_coarse=is_coarse) for episode in chosen for text in episode]
    groups = np.array([number for number, episode in enumerate(chosen) for _ in episode])
    is_second = groups >= count
    ngrams = CountVectorizer(
        tokenizer=str.split,
        token_pattern=None,
        lowercase=False,
        ngram_range=(1, LONGEST),
        min_df=MIN_TEXTS,
        binary=True,
    )
    contained = ngrams.fit_transform(texts)
    correct = np.zeros(len(texts), dtype=bool)
    for train, test in GroupKFold(FOLDS, shuffle=True, random_state=seed).split(contained, groups=groups):
        model = LogisticRegression(C=STRENGTH, max_iter=2000).fit(contained[train], is_second[train])
        correct[test] = model.predict(contained[test]) == is_second[test]
    weights = LogisticRegression(C=STRENGTH, max_iter=2000).fit(contained, is_second).coef_[0]
    names = ngrams.get_feature_names_out()
    shares = [np.asarray(contained[side].mean(axis=0)).ravel() for side in (~is_second, is_second)]
    listed = [(str(names[at]), float(shares[0][at]), float(shares[1][at])) for at in np.argsort(weights)]
    return Distinction(
        float(correct.mean()), _interval(correct, groups, seed), int(is_second.sum()), listed[:40], listed[::-1][:40]
    )


def _interval(correct: np.ndarray, groups: np.ndarray, seed: int) -> tuple[float, float]:
    """Return the 95% bootstrap interval of the mean over episodes."""
    right, number = np.bincount(groups, correct), np.bincount(groups)
    drawn = np.random.default_rng(seed).integers(len(number), size=(RESAMPLES, len(number)))
    means = right[drawn].sum(axis=1) / number[drawn].sum(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return float(low), float(high)


def control(texts: Texts, language: str, count: int, *, is_coarse: bool = True, seed: int = 1) -> Distinction:
    """Return how well two random halves of one set's episodes are told apart, at most `count` episodes in each."""
    shuffled = seeded("control", seed).sample(list(texts), len(texts))
    half = min(len(shuffled) // 2, count)
    return distinguish(shuffled[:half], shuffled[half : 2 * half], language, is_coarse=is_coarse, seed=seed)


def generated_texts(data: Path, language: str, phase: str) -> Texts:
    """Return a data folder's texts of a phase by episode; episodes without the language are left out."""
    found = []
    for path in sorted(data.glob("splits/*/episodes.jsonl")):
        for line in path.read_text(encoding="utf-8").splitlines()[1:]:
            turns = json.loads(line)["instructions"].get(language, ())
            if turns:
                found.append([turn[phase] for turn in turns])
    return found


def compared_texts(language: str, phase: str) -> Texts:
    """Return the texts to compare with, by episode: people's in English, the free paraphrases in Hindi.

    Raises:
        FileNotFoundError: if the release is needed and ARRAMON_RELEASE does not name its folder.
    """
    if language == "en":
        release = json.loads((Path(os.environ.get("ARRAMON_RELEASE", "")) / "val_seen.json").read_text("utf-8"))
        return [episode["instructions"][PHASES[phase]] for episode in release]
    by_episode: dict[str, list[str]] = {}
    for each in paraphrases():
        if each.language == language:
            by_episode.setdefault(each.episode, []).append(getattr(each, phase))
    return list(by_episode.values())


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--lang", choices=("en", "hi"), default="en", help="language (default: %(default)s)")
    parser.add_argument("--features", type=positive_int, default=15, metavar="N", help="n-grams to list on each side")
    arguments = parser.parse_args(argv)
    for phase in PHASES:
        try:
            theirs = compared_texts(arguments.lang, phase)
            ours = generated_texts(arguments.data, arguments.lang, phase)
            for is_coarse, title in ((True, "words alone"), (False, "with marks and kinds of things")):
                found = distinguish(theirs, ours, arguments.lang, is_coarse=is_coarse)
                same = control(theirs, arguments.lang, len(ours), is_coarse=is_coarse)
                _print(f"{phase}, {arguments.lang}, {title}", found, same, arguments.features)
        except (FileNotFoundError, ValueError) as error:
            print(f"distinguish: {error}", file=sys.stderr)
            return 1
    return 0


def _print(title: str, found: Distinction, same: Distinction, features: int) -> None:
    print(f"{title}: {found.texts} texts a side are told apart at {_shown(found)}")
    print(f"  control, {same.texts} a side: {_shown(same)}")
    for side, listed in (("more often theirs", found.first), ("more often generated", found.second)):
        rows = [[name, f"{100 * a:.1f}%", f"{100 * b:.1f}%"] for name, a, b in listed[:features]]
        print(text_table([side, "theirs", "generated"], rows), end="\n\n")


def _shown(found: Distinction) -> str:
    return f"{found.accuracy:.3f} ({found.interval[0]:.3f} to {found.interval[1]:.3f})"


if __name__ == "__main__":
    sys.exit(main())
