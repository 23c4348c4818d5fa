"""Follower given only the target's name, or another episode's text: `python -m benchmarks.instructions.guessing DATA`.

Plays episodes of a data folder in English with the full navigation texts, with the target's name alone, and with the
texts of another episode; the room's texts are always the full ones. The less a name alone leads to the target, the more
the route is worth. Prints CTC-3 and nDTW over both turns, and the name's apart for turns with another object of the
target's type.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import arramon_lang as lang
from arramon_dataset.generation import GenerationSite
from arramon_dataset.instruction_writer import make_instruction_writer
from arramon_dataset.randomness import seeded
from arramon_dataset.trial import play
from arramon_lang.meaning import Navigation, Thing
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import read_splits
from arramon_server.sim.own_furniture import furnished
from benchmarks.common import parser_of, positive_int, text_table

LANGUAGE = "en"
METRICS = ("CTC-3", "nDTW")

Texts = tuple[Instructions, Instructions]


def with_target_name_only(episode: Episode) -> Texts:
    """Return an episode's texts with navigation reduced to the target's name."""
    named = []
    for number, (turn, text) in enumerate(zip(episode.turns, episode.instructions[LANGUAGE], strict=True)):
        kind = turn.target.type
        meaning = Navigation((), Thing(kind.kind, kind.colour, kind.pattern))
        said = lang.load(LANGUAGE).write(meaning, seeded(episode.episode_id, number, "name"))
        named.append(Instructions(said, text.assembly))
    return named[0], named[1]


def has_twin(episode: Episode, turn: int) -> bool:
    """Return whether another object of a turn looks like its target; turns from 0."""
    target, *others = episode.turns[turn].street
    return any(other.type == target.type for other in others)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--split", default="val_seen", help="one of its splits (default: %(default)s)")
    parser.add_argument(
        "--episodes", type=positive_int, default=60, help="number of its episodes (default: %(default)s)"
    )
    arguments = parser.parse_args()

    split = read_splits(arguments.data)[arguments.split]
    step = max(1, len(split.episodes) // arguments.episodes)
    chosen = list(split.episodes.values())[::step][: arguments.episodes]
    follower = make_instruction_writer().make_follower
    sites = {name: GenerationSite(section) for name, section in split.sections.items()}
    scores: dict[str, list[Mapping[str, float]]] = defaultdict(list)
    for number, episode in enumerate(chosen):
        site = sites[episode.section]
        if not episode.furniture.is_empty:
            site = GenerationSite(furnished(site.section, episode.furniture))
        world = site.in_episode(episode.layout)
        full, other = episode.instructions[LANGUAGE], chosen[number - 1].instructions[LANGUAGE]
        swapped = [Instructions(o.navigation, f.assembly) for o, f in zip(other, full, strict=True)]
        variants: dict[str, Texts] = {
            "full text": full,
            "target's name alone": with_target_name_only(episode),
            "another episode's text": (swapped[0], swapped[1]),
        }
        for name, (first, second) in variants.items():
            played = replace(episode, instructions={LANGUAGE: (first, second)})
            turns = play(follower(), played, LANGUAGE, world).turns
            scores[name] += turns
            if name == "target's name alone":
                for turn, values in enumerate(turns):
                    scores[f"  {'two' if has_twin(episode, turn) else 'one'} of the type"].append(values)
    rows = []
    for name, listed in scores.items():
        means = (sum(turn[metric] for turn in listed) / len(listed) for metric in METRICS)
        rows.append([name, str(len(listed)), *(f"{mean:.2f}" for mean in means)])
    print(text_table(["", "turns", *METRICS], rows))


if __name__ == "__main__":
    main()
