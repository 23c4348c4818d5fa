"""The follower on people's texts in two reconstructed cities: `python -m benchmarks.release.people DATA`.

Plays episodes of an imported split with their own navigation texts and with those of another episode of the section,
in the city with furniture recovered from the texts, and in the same streets with random furniture. The room's
texts are always the episode's own. Prints nDTW, CTC-3 and PTC of the turns, by whether all street furniture that the
text names exists in that city (`arramon_dataset.world_check`), with standard errors. The texts of an imported split
helped to build its city: these are no held-out scores. `--played FILE` stores each played episode; the
same command resumes from there.
"""

import json
import math
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from arramon_dataset.instruction_writer import make_instruction_writer
from arramon_dataset.release.landmarks.mentions import FURNITURE, events_of
from arramon_dataset.trial import play
from arramon_dataset.world_check import missing_furniture
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.sim.own_furniture import NO_FURNITURE
from arramon_server.sim.section import Section
from arramon_server.sim.section_world import SectionWorld
from benchmarks.common import add_json, mean_and_error, parser_of, positive_int, text_table, write_json
from benchmarks.release.drawn_furniture import reconstruct

METRICS = ("nDTW", "CTC-3", "PTC")
ALL, SOME, NONE = "all there", "some missing", "none named"
CITIES, TEXTS = ("rebuilt", "before"), ("own text", "another's text")


@dataclass(frozen=True, slots=True)
class TurnScores:
    """The scores of one turn, and whether the furniture that its own text names exists."""

    episode: str
    city: str
    text: str
    there: str
    scores: Mapping[str, float]


def named_furniture_present(text: str, language: str, episode: Episode, turn: int, section: Section) -> str:
    """Return how much of the furniture that a text names exists in the section: ALL, SOME or NONE."""
    if not any(event.kind in FURNITURE for event in events_of(text, language)):
        return NONE
    return SOME if missing_furniture(text, language, episode, turn, section) else ALL


def with_random_furniture(section: Section, episodes: Sequence[Episode]) -> Section:
    """Return the section with random furniture, independent of the texts."""
    turns = [turn for episode in episodes for turn in episode.turns]
    targets = np.array([(turn.target.position.x, turn.target.position.z) for turn in turns])
    return reconstruct(section.id, [np.array(turn.path) for turn in turns], targets)


def with_texts(episode: Episode, other: Episode, language: str) -> Episode:
    """Return an episode with the navigation texts of another one."""
    own = episode.instructions[language]
    swapped = [
        Instructions(said.navigation, mine.assembly)
        for said, mine in zip(other.instructions[language], own, strict=True)
    ]
    return replace(episode, instructions={language: (swapped[0], swapped[1])})


def measure(
    split: Split, section_id: str, language: str, chosen: range, until: float, known: Set[str], kept: Path | None
) -> list[TurnScores]:
    """Play the episodes of a section that `chosen` numbers in playing order, until a time of `time.time`.

    Episodes that are known are left out. Each that is played is added to the file at `kept`, one line an episode.
    """
    members = [one for one in split.in_playing_order(language) if one.section == section_id]
    plain = [replace(one, furniture=NO_FURNITURE) for one in members]
    section, added = split.sections[section_id], [prop for one in members for prop in one.furniture.added]
    cities = {
        "rebuilt": (SectionWorld(section, spare=lambda: added), members),
        "before": (SectionWorld(with_random_furniture(section, members)), plain),
    }
    follower = make_instruction_writer().make_follower
    played: list[TurnScores] = []
    for place in chosen[: max(0, len(members) - chosen.start)]:
        if members[place].episode_id in known:
            continue
        first = len(played)
        for name, (city, episodes) in cities.items():
            episode, other = episodes[place], episodes[place - 1]
            states = [
                named_furniture_present(text.navigation, language, episode, turn, city.section)
                for turn, text in enumerate(episode.instructions[language], start=1)
            ]
            for text, one in (("own text", episode), ("another's text", with_texts(episode, other, language))):
                scores = play(follower(), one, language, city.in_episode(episode.furniture, episode.layout)).turns
                played += [
                    TurnScores(episode.episode_id, name, text, state, turn)
                    for state, turn in zip(states, scores, strict=True)
                ]
        if kept:
            with kept.open("a") as file:
                file.write(json.dumps([asdict(one) for one in played[first:]]) + "\n")
        if time.time() > until:
            break
    return played


def read_played(file: Path) -> list[TurnScores]:
    """Return the turns that an earlier command has played."""
    return [TurnScores(**one) for line in file.read_text().splitlines() for one in json.loads(line)]


def rows(played: Sequence[TurnScores]) -> Iterator[tuple[str, str, str, list[Mapping[str, float]]]]:
    """Yield city, text, group of turns and their scores."""
    groups: dict[tuple[str, str, str], list[Mapping[str, float]]] = defaultdict(list)
    for one in played:
        for name in ("all turns", one.there):
            groups[one.city, one.text, name].append(one.scores)
    for city in CITIES:
        for name in ("all turns", ALL, SOME, NONE):
            for text in TEXTS:
                yield city, text, name, groups[city, text, name]


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server import-release`")
    parser.add_argument("--split", default="val_seen", help="one of its imported splits (default: %(default)s)")
    parser.add_argument("--lang", default="en", help="language of the texts (default: %(default)s)")
    parser.add_argument(
        "--episodes", type=positive_int, default=10**6, help="number of episodes of each section (default: all)"
    )
    parser.add_argument("--skip", type=int, default=0, help="skip the first N of each section")
    parser.add_argument("--seconds", type=float, default=math.inf, help="stop after about this time")
    parser.add_argument("--jobs", type=positive_int, default=1, help="number of processes (default: %(default)s)")
    parser.add_argument(
        "--played", type=Path, metavar="FILE", help="file of what was played, of this split and language"
    )
    add_json(parser)
    arguments = parser.parse_args()

    split = read_split(split_folder(arguments.data, arguments.split))
    sections = sorted(split.sections)
    chosen = range(arguments.skip, arguments.skip + arguments.episodes)
    share = arguments.seconds * arguments.jobs / len(sections)
    begun = time.time()
    kept: Path | None = arguments.played
    played = read_played(kept) if kept and kept.exists() else []
    known = {one.episode for one in played}
    if arguments.jobs == 1:
        for section in sections:
            played += measure(split, section, arguments.lang, chosen, time.time() + share, known, kept)
            print(f"section {section}: {len(played) // 4} turns so far, {time.time() - begun:.0f} s", file=sys.stderr)
    else:
        with ProcessPoolExecutor(arguments.jobs) as pool:
            tasks = [
                pool.submit(measure, split, name, arguments.lang, chosen, begun + arguments.seconds, known, kept)
                for name in sections
            ]
            for task in tasks:
                played += task.result()
    table, lines = [], []
    for city, text, group, scores in rows(played):
        if not scores:
            continue
        means = {name: mean_and_error([one[name] for one in scores]) for name in METRICS}
        table.append({"city": city, "text": text, "turns": group, "number": len(scores), "scores": means})
        values = (f"{value:.3f} ±{error:.3f}" for value, error in means.values())
        lines.append([f"{city}, {group}, {text}", str(len(scores)), *values])
    print(text_table(["", "turns", *METRICS], lines))
    write_json(arguments.json, {"split": split.name, "data": split.data_hash, "rows": table})


if __name__ == "__main__":
    main()
