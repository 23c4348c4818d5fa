"""Accuracy of reader and follower on the free paraphrases of `val_unseen_paraphrased`.

    python -m benchmarks.instructions.paraphrases [--half development|test] [--lang en hi] [--show N] [--play N]
                                                  [--batches]

Whether the reader finds the target's name and the cell is known for all texts; whether it recovers the whole meaning is
measured where a person has written it down (`benchmarks/instructions/agreement.py`). With --play the follower also
plays N episodes, with the paraphrases and with the texts that the grammar wrote for the same episodes. Look at texts of
the development half only; the test half is for figures. With --batches the texts of the development half are read whose
meanings were written down later, batch by batch.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import arramon_lang as lang
from arramon_agents.follower import Agent as Follower
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.instructions.assembly.visible_objects import whole_room
from arramon_dataset.paraphrases.collection import (
    HALVES,
    Paraphrase,
    generated_episodes,
    paraphrased_episodes,
    paraphrased_section,
    paraphrases,
)
from arramon_dataset.paraphrases.room_facts import room_before
from arramon_dataset.trial import play
from arramon_lang.cell_grading import find_cell
from arramon_lang.meaning import Assembly, Meaning, Navigation
from arramon_server.episodes.episode import Episode
from arramon_server.sim.section_world import EpisodeWorld
from benchmarks.common import parser_of
from benchmarks.instructions.agreement import assembly_agrees, navigation_agrees
from benchmarks.instructions.meanings import development_meanings

PHASES = ("navigation", "assembly")

METRICS = ("nDTW", "CTC-3", "PTC")


def is_fully_parsed(text: Paraphrase, phase: str) -> bool:
    """Return whether the reader recovers the whole annotated meaning of a text."""
    assert text.meaning is not None
    return _agrees(text, phase, text.meaning)


def _agrees(text: Paraphrase, phase: str, said: Mapping[str, Any]) -> bool:
    meaning = _read(text, phase)
    if isinstance(meaning, Navigation):
        return navigation_agrees(meaning, said)
    return isinstance(meaning, Assembly) and assembly_agrees(meaning, said)


def names_target(text: Paraphrase, episode: Episode) -> bool:
    """Return whether the target's kind, and the colour and pattern found by the reader, are right."""
    meaning, target = _read(text, "navigation"), episode.turns[text.turn - 1].target.type
    if not isinstance(meaning, Navigation) or meaning.target.kind != target.kind:
        return False
    return meaning.target.colour in ("", target.colour) and meaning.target.look in ("", target.pattern)


def leads_to_cell(text: Paraphrase, episode: Episode) -> bool:
    """Return whether the reader's meaning of the assembly fits the target's cell better than any other."""
    meaning, cell = _read(text, "assembly"), episode.turns[text.turn - 1].target_cell
    room = whole_room(room_before(episode, text.turn))
    return isinstance(meaning, Assembly) and find_cell(meaning, room)[0] == (cell.column, cell.row)


def _read(text: Paraphrase, phase: str) -> Meaning | None:
    try:
        return lang.load(text.language).read(getattr(text, phase), phase)
    except lang.CannotRead:
        return None


def _reading(texts: Sequence[Paraphrase], language: str, show: int) -> None:
    episodes = {episode.episode_id: episode for episode in generated_episodes()}
    mine = [text for text in texts if text.language == language]
    found: dict[str, list[tuple[str, bool]]] = defaultdict(list)
    for text in mine:
        episode = episodes[text.episode]
        found["the target is named right"].append((text.manner, names_target(text, episode)))
        found["the assembly leads to the cell"].append((text.manner, leads_to_cell(text, episode)))
        if text.meaning is not None:
            for phase in PHASES:
                right = is_fully_parsed(text, phase)
                found[f"whole meaning of {phase}"].append((text.manner, right))
                if not right and show > 0:
                    show -= 1
                    print(f"  {text.episode}/{text.turn} {phase}: {getattr(text, phase)}")
    for name, results in found.items():
        manners = sorted({manner for manner, _ in results})
        by_manner = (f"{manner} {_share(right for each, right in results if each == manner)}" for manner in manners)
        print(f"{language} {name}: {_share(right for _, right in results)} of {len(results)}; {', '.join(by_manner)}")


def _reading_batches(language: str, show: int) -> None:
    found: dict[int, dict[str, list[tuple[bool, bool]]]] = defaultdict(lambda: defaultdict(list))
    for written in development_meanings(language):
        for phase in PHASES if "room" in written.meaning else PHASES[:1]:
            right = _agrees(written.text, phase, written.meaning)
            found[written.batch][phase].append((right, phase in written.doubtful))
            if not right and show > 0:
                show -= 1
                print(f"  {written.text.episode}/{written.text.turn} {phase}: {getattr(written.text, phase)}")
    for batch, phases in sorted(found.items()):
        for phase, results in phases.items():
            sure = [right for right, is_doubtful in results if not is_doubtful]
            shares = (
                f"{_share(right for right, _ in results)} of {len(results)}, {_share(sure)} of {len(sure)} not doubtful"
            )
            print(f"{language} batch {batch}, whole meaning of {phase}: {shares}")


def _share(results: Iterable[bool]) -> str:
    listed = list(results)
    return f"{sum(listed) / len(listed):.3f}"


def _playing(language: str, ids: Sequence[str]) -> None:
    section = paraphrased_section()
    site = GenerationSite(section)
    sources = {"paraphrases": paraphrased_episodes(), "the grammar's texts": generated_episodes()}
    for name, episodes in sources.items():
        scores = [
            _scores(episode, language, site.in_episode(episode.layout))
            for episode in episodes
            if episode.episode_id in ids
        ]
        means = (
            f"{metric} {sum(one[metric] for one in scores) / len(scores):.3f}"
            for metric in METRICS
            if metric in scores[0]
        )
        print(f"{language} follower with {name}, {len(scores)} episodes: {', '.join(means)}")


def _scores(episode: Episode, language: str, world: EpisodeWorld) -> dict[str, float]:
    turns = play(Follower(), episode, language, world).turns
    return {name: sum(turn[name] for turn in turns) / len(turns) for name in turns[0]}


def main() -> None:
    """Print the share of texts that are understood, by manner, and the follower's scores."""
    parser = parser_of(__doc__)
    parser.add_argument("--half", choices=HALVES, default=HALVES[0], help="(default: %(default)s)")
    parser.add_argument("--lang", nargs="+", default=["en", "hi"], help="languages (default: both)")
    parser.add_argument("--show", type=int, default=0, metavar="N", help="print N texts that are not understood")
    parser.add_argument("--play", type=int, default=0, metavar="N", help="let the follower play N episodes")
    parser.add_argument("--batches", action="store_true", help="evaluate the later annotations, batch by batch")
    arguments = parser.parse_args()
    if arguments.batches:
        for language in arguments.lang:
            _reading_batches(language, arguments.show)
        return
    texts = [text for text in paraphrases() if text.half == arguments.half]
    ids = sorted({text.episode for text in texts}, key=int)[: arguments.play]
    for language in arguments.lang:
        _reading(texts, language, arguments.show)
        if ids:
            _playing(language, ids)


if __name__ == "__main__":
    main()
