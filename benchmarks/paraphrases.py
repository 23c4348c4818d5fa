"""Measure the reader and the follower on the free paraphrases of `val_unseen_paraphrased`.

    python benchmarks/paraphrases.py [--half development|test] [--lang en hi] [--show N] [--play N]

A navigation or assembly text counts as read if the whole meaning agrees with what a person's reading of it says
(`server/dataset/paraphrases/agreement.py`). With --play the follower also plays N episodes, with the paraphrases and
with the texts that the grammar wrote for the same episodes. Look at texts of the development half only; the test half
is for figures.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import lang
from agents.follower import Agent as Follower
from lang.meaning import Assembly, Navigation
from server.dataset.generation.site import Site
from server.dataset.instruction_writer import room_camera
from server.dataset.paraphrases.agreement import assembly_agrees, navigation_agrees
from server.dataset.paraphrases.collection import (
    HALVES,
    Paraphrase,
    generated_episodes,
    paraphrased_episodes,
    paraphrased_section,
    paraphrases,
)
from server.dataset.trial import TrialWorld, play
from server.episodes.episode import Episode

METRICS = ("nDTW", "CTC-3", "PTC")


def is_read(text: Paraphrase, phase: str) -> bool:
    """Return whether the reader recovers the whole meaning of a text."""
    try:
        meaning = lang.load(text.language).read(getattr(text, phase), phase)
    except lang.CannotRead:
        return False
    if isinstance(meaning, Navigation):
        return navigation_agrees(meaning, text.meaning)
    assert isinstance(meaning, Assembly)
    return assembly_agrees(meaning, text.meaning)


def _reading(texts: Sequence[Paraphrase], language: str, show: int) -> None:
    shown = 0
    read: Counter[tuple[str, str]] = Counter()
    count: Counter[str] = Counter()
    for text in (text for text in texts if text.language == language):
        count[text.manner] += 1
        count["all"] += 1
        for phase in ("navigation", "assembly"):
            right = is_read(text, phase)
            read[text.manner, phase] += right
            read["all", phase] += right
            if not right and shown < show:
                shown += 1
                print(f"  {text.episode}/{text.turn} {phase}: {getattr(text, phase)}")
    for manner in count:
        shares = (f"{phase} {read[manner, phase] / count[manner]:.3f}" for phase in ("navigation", "assembly"))
        print(f"{language} {manner:10} whole meaning read, of {count[manner]} turns: {', '.join(shares)}")


def _playing(language: str, ids: Sequence[str]) -> None:
    section = paraphrased_section()
    site = Site(section)
    world = TrialWorld(site.world, site.camera, room_camera())
    sources = {"paraphrases": paraphrased_episodes(), "the grammar's texts": generated_episodes()}
    for name, episodes in sources.items():
        scores = [_scores(episode, language, world) for episode in episodes if episode.episode_id in ids]
        means = (
            f"{metric} {sum(one[metric] for one in scores) / len(scores):.3f}"
            for metric in METRICS
            if metric in scores[0]
        )
        print(f"{language} follower with {name}, {len(scores)} episodes: {', '.join(means)}")


def _scores(episode: Episode, language: str, world: TrialWorld) -> dict[str, float]:
    turns = play(Follower(), episode, language, world).turns
    return {name: sum(turn[name] for turn in turns) / len(turns) for name in turns[0]}


def main() -> None:
    """Print the shares of texts read, by manner, and the follower's scores."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--half", choices=HALVES, default=HALVES[0], help="(default: %(default)s)")
    parser.add_argument("--lang", nargs="+", default=["en", "hi"], help="languages (default: both)")
    parser.add_argument("--show", type=int, default=0, metavar="N", help="print N texts that are not read")
    parser.add_argument("--play", type=int, default=0, metavar="N", help="let the follower play N episodes")
    arguments = parser.parse_args()
    texts = [text for text in paraphrases() if text.half == arguments.half]
    ids = sorted({text.episode for text in texts}, key=int)[: arguments.play]
    for language in arguments.lang:
        _reading(texts, language, arguments.show)
        if ids:
            _playing(language, ids)


if __name__ == "__main__":
    main()
