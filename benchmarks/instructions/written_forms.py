"""Accuracy of reader and follower on texts that were written by hand in the forms that people type.

    python -m benchmarks.instructions.written_forms [--half development|test] [--show N] [--no-play]

40 texts of ten episodes of `val_unseen_paraphrased`, written from the annotated meanings alone before the reader knew
any form but plain texts, in the voices of different people (`data/README.md`). The development half may be looked at,
the test half is for figures. CTC-3 is the follower's, beside its own with the free paraphrases whose meaning they say
again.
"""

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

import arramon_lang as lang
from arramon_agents.follower import Agent as Follower
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.instructions.assembly.visible_objects import whole_room
from arramon_dataset.paraphrases.collection import (
    HALVES,
    generated_episodes,
    paraphrased_episodes,
    paraphrased_section,
)
from arramon_dataset.paraphrases.room_facts import room_before
from arramon_dataset.trial import play
from arramon_lang.cell_grading import find_cell
from arramon_lang.meaning import Assembly, Meaning, Navigation
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.scoring.intervals import episode_moments, mean_bounds
from benchmarks.common import parser_of, text_table
from benchmarks.instructions.agreement import navigation_agrees
from benchmarks.instructions.meanings import DATA, development_meanings

ANNOTATED = "hi"
"""Language of the paraphrases whose annotated meanings the texts say again."""


@dataclass(frozen=True, slots=True)
class WrittenEpisode:
    """The texts of an episode in one form.

    Attributes:
        half: one of `HALVES`.
        form: such as "romanised".
        language: code.
        episode: with these texts.
    """

    half: str
    form: str
    language: str
    episode: Episode


def written_episodes() -> Iterator[WrittenEpisode]:
    """Yield all episodes with hand-written texts, once for each form in which they are written."""
    episodes = {episode.episode_id: episode for episode in generated_episodes()}
    turns: dict[tuple[str, str, str, str], dict[int, Instructions]] = defaultdict(dict)
    for line in (DATA / "written_forms.jsonl").read_text(encoding="utf-8").splitlines():
        text = json.loads(line)
        key = text["half"], text["form"], text["language"], text["episode"]
        turns[key][text["turn"]] = Instructions(text["navigation"], text["assembly"])
    for (half, form, language, episode_id), texts in turns.items():
        instructions = {language: (texts[1], texts[2])}
        yield WrittenEpisode(half, form, language, replace(episodes[episode_id], instructions=instructions))


def _read(text: str, phase: str, language: str) -> Meaning | None:
    try:
        return lang.load(language).read(text, phase)
    except lang.CannotRead:
        return None


def results_of_turn(written: WrittenEpisode, turn: int) -> dict[str, bool]:
    """Return whether the target is named right, the assembly leads to its cell, and the whole route is understood."""
    episode, texts = written.episode, written.episode.instructions[written.language][turn - 1]
    navigation = _read(texts.navigation, "navigation", written.language)
    assembly = _read(texts.assembly, "assembly", written.language)
    truth = episode.turns[turn - 1]
    cell = None
    if isinstance(assembly, Assembly):
        cell = find_cell(assembly, whole_room(room_before(episode, turn)))[0]
    said = next(
        each.meaning
        for each in development_meanings(ANNOTATED)
        if (each.text.episode, each.text.turn) == (episode.episode_id, turn)
    )
    is_named = isinstance(navigation, Navigation) and (
        (navigation.target.kind, navigation.target.colour, navigation.target.look)
        == (truth.target.type.kind, truth.target.type.colour, truth.target.type.pattern)
    )
    return {
        "target": is_named,
        "cell": cell == (truth.target_cell.column, truth.target_cell.row),
        "route": isinstance(navigation, Navigation) and navigation_agrees(navigation, said),
    }


def main() -> None:
    """Print the results by form, and over all."""
    parser = parser_of(__doc__)
    parser.add_argument("--half", choices=HALVES, default=HALVES[0], help="(default: %(default)s)")
    parser.add_argument("--show", type=int, default=0, metavar="N", help="print N texts that are not understood")
    parser.add_argument("--no-play", action="store_true", help="read the texts only")
    arguments = parser.parse_args()
    site = GenerationSite(paraphrased_section())
    rows: dict[str, list[dict[str, float]]] = defaultdict(list)
    plain: list[float] = []
    originals = {episode.episode_id: episode for episode in paraphrased_episodes()}
    for written in (each for each in written_episodes() if each.half == arguments.half):
        scores: Sequence[float] = ()
        if not arguments.no_play:
            world = site.in_episode(written.episode.layout)
            scores = [turn["CTC-3"] for turn in play(Follower(), written.episode, written.language, world).turns]
            original = originals[written.episode.episode_id]
            plain += [turn["CTC-3"] for turn in play(Follower(), original, ANNOTATED, world).turns]
        for turn in (1, 2):
            results = results_of_turn(written, turn)
            played = {"CTC-3": scores[turn - 1]} if scores else {}
            rows[written.form].append({**results, **played})
            if arguments.show > 0 and not all(results.values()):
                arguments.show -= 1
                texts = written.episode.instructions[written.language][turn - 1]
                missed = ", ".join(name for name, right in results.items() if not right)
                print(f"{written.episode.episode_id}/{turn} {written.form}, {missed}:")
                print(f"  {texts.navigation} // {texts.assembly}")
    every = [each for listed in rows.values() for each in listed]
    names = list(every[0])
    table = [
        [form, str(len(listed)), *(f"{sum(each[name] for each in listed) / len(listed):.2f}" for name in names)]
        for form, listed in [*sorted(rows.items()), ("all", every)]
    ]
    print(text_table(["form", "turns", *names], table))
    if not arguments.no_play:
        values = np.array([each["CTC-3"] for each in every]).reshape(-1, 2).mean(axis=1)
        bounds = mean_bounds(episode_moments(values[:, None], np.zeros(len(values), dtype=np.intp)))
        print(f"CTC-3 of all: {bounds.mean[0]:.2f} ({bounds.low[0]:.2f} to {bounds.high[0]:.2f})")
        print(f"with the free paraphrases of the same meaning: {sum(plain) / len(plain):.2f}")


if __name__ == "__main__":
    main()
