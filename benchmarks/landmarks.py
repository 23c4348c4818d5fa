"""How true human texts are in a city recovered from them: `python benchmarks/landmarks.py val_seen.json`.

Recovers each section's fixed scenery from the texts of half of its episodes, gives every episode of the other half its own
furniture from its own texts, and counts in that half the mentions and turns that fit: each thing named is there (kind, and
colour and side where said) within 4 units of where the text's alignment in that world puts it. Beside it: the same scenery
with its kinds permuted, all furniture at random places of the same ground, and the furniture of before, drawn without a
text. `--visible` also counts how many of the things that fit the camera shows in the steps before they are spoken of.
"""

import argparse
import json
import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from server.dataset.randomness import seeded
from server.dataset.release.files import read_release
from server.dataset.release.landmarks.agreement import Standing, by_kind, mentions_of, standing_of
from server.dataset.release.landmarks.alignment import align
from server.dataset.release.landmarks.ground import Ground, Room
from server.dataset.release.landmarks.mentions import SCENERY
from server.dataset.release.landmarks.own import moved_off, own_furniture, wanted
from server.dataset.release.landmarks.recovery import Map, Told, recover, told_of
from server.dataset.release.landmarks.scenery import props_of
from server.dataset.release.reconstruction import reconstruct
from server.episodes.episode import Episode
from server.sim.own_furniture import OwnFurniture, furnished
from server.sim.section import Prop, Section

KNOWN = 0.8
"""Strength of each thing of a world in the alignment of a text to that world."""

Counts = dict[str, Counter[str]]
"""For each world the number of turns, of turns that fit, of mentions and of mentions that fit, by kind."""


def main() -> int:
    """Run the benchmark and print its tables."""
    parser = argparse.ArgumentParser(prog="landmarks", description=__doc__.split("\n\n")[0])
    parser.add_argument("file", type=Path, help="a file of the official release")
    parser.add_argument("--lang", help="code of the file's language; without it detected from the texts")
    parser.add_argument("--output", type=Path, help="output JSON file")
    arguments = parser.parse_args()

    language, episodes = read_release(arguments.file, arguments.lang)
    by_section: dict[str, list[Episode]] = defaultdict(list)
    for episode in episodes:
        by_section[episode.section].append(episode)
    total: Counts = defaultdict(Counter)
    with ProcessPoolExecutor(2) as pool:
        for section, (counts, landmarks) in zip(
            by_section, pool.map(measure, by_section, by_section.values()), strict=True
        ):
            print(f"section {section}: {len(by_section[section])} episodes, {landmarks:g} landmarks from half of them")
            for world, numbers in counts.items():
                total[world].update(numbers)
                print(f"  {world:12}{_line(numbers)}")
    print(f"all, {language}")
    for world, numbers in total.items():
        print(f"  {world:12}{_line(numbers)}")
    print("by kind: mentions that fit, with kinds permuted in brackets, number of mentions")
    for kind in sorted({name.split()[1] for name in total["held out"] if name.startswith("all ")}):
        shares = [
            total[world][f"fits {kind}"] / max(1, total[world][f"all {kind}"]) for world in ("held out", "permuted")
        ]
        print(f"  {kind:14}{shares[0]:.2f} ({shares[1]:.2f}) {total['held out'][f'all {kind}']}")
    if arguments.output:
        arguments.output.write_text(json.dumps({world: dict(numbers) for world, numbers in total.items()}, indent=1))
    return 0


def _line(numbers: Counter[str]) -> str:
    return (
        f"turns that fit {numbers['turn fits'] / max(1, numbers['turns']):.3f} of {numbers['turns']}, "
        f"mentions {numbers['mention fits'] / max(1, numbers['mentions']):.3f} of {numbers['mentions']}, "
        f"of scenery {numbers['scenery fits'] / max(1, numbers['scenery']):.3f} of {numbers['scenery']}"
    )


def measure(section_id: str, episodes: Sequence[Episode]) -> tuple[Counts, float]:
    """Return the counts of a section's worlds, and the mean number of landmarks of both halves."""
    paths = [np.array(turn.path) for episode in episodes for turn in episode.turns]
    targets = np.array([(t.target.position.x, t.target.position.z) for e in episodes for t in e.turns])
    section = reconstruct(section_id, paths, targets)
    walked = np.concatenate(paths)
    ground = Ground.of(section.heading, section.buildings, walked)
    told = {episode.episode_id: told_of(episode) for episode in episodes}
    counts: Counts = defaultdict(Counter)
    found = 0
    order = {episode.episode_id: number for number, episode in enumerate(episodes)}
    for half in (0, 1):
        known = [
            each for episode in episodes if order[episode.episode_id] % 2 != half for each in told[episode.episode_id]
        ]
        landmarks = recover(known)
        found += len(landmarks)
        names = [(each.kind, each.colour, each.look) for each in landmarks]
        seeded(section_id, half, "permuted").shuffle(names)
        permuted = [
            replace(each, kind=kind, colour=colour, look=look)
            for each, (kind, colour, look) in zip(landmarks, names, strict=True)
        ]
        worlds = {
            name: replace(
                section,
                props=tuple(prop for prop, _ in props_of(listed, section.heading, section.buildings, ground, walked)),
            )
            for name, listed in (("held out", landmarks), ("permuted", permuted))
        }
        for episode in episodes[half::2]:
            for name, world in worlds.items():
                own = furniture_of(episode, told[episode.episode_id], world, ground)
                things = list(furnished(world, own).props)
                _count(counts[name], told[episode.episode_id], things)
                if name == "held out":
                    _count(counts["random"], told[episode.episode_id], scattered(episode.episode_id, things, ground))
            _count(counts["before"], told[episode.episode_id], section.props)
    return counts, found / 2


def furniture_of(episode: Episode, told: Sequence[Told], world: Section, ground: Ground) -> OwnFurniture:
    """Return an episode's own furniture in a section: what its texts ask for, and what is in its way moved."""
    walked = walked_points([np.array(turn.path) for turn in episode.turns])
    objects = np.array([(each.position.x, each.position.z) for turn in episode.turns for each in turn.street])
    moved, left_out = moved_off(world.props, ground, walked, objects)
    changed = OwnFurniture((), tuple(moved), tuple(left_out))
    standing = furnished(world, changed).props
    known = Map.of(by_kind(standing_of(standing), KNOWN))
    own = own_furniture(episode.episode_id, wanted(told, known, ground), ground, walked, objects, standing)
    return replace(changed, added=tuple(own))


def scattered(episode_id: str, props: Sequence[Prop], ground: Ground) -> list[Prop]:
    """Return the props at random places."""
    random = seeded(episode_id, "scattered")
    places = [ground.places[random.randrange(len(ground.places))] for _ in props]
    return [replace(prop, x=float(x), z=float(z)) for prop, (x, z) in zip(props, places, strict=True)]


def _count(counts: Counter[str], told: Sequence[Told], props: Sequence[Prop]) -> None:
    """Add to the counts the turns and the mentions that fit a world."""
    things: list[Standing] = standing_of(props)
    known = Map.of(by_kind(things, KNOWN))
    for each in told:
        fitting = []
        if each.events:
            for event, _, thing in mentions_of(
                each.events, align(each.events, each.walk, known.fit), each.walk, things
            ):
                fitting.append(thing >= 0)
                counts[f"all {event.sort}"] += 1
                counts[f"fits {event.sort}"] += thing >= 0
                counts["scenery"] += event.sort in SCENERY
                counts["scenery fits"] += event.sort in SCENERY and thing >= 0
        if fitting:
            counts["turns"] += 1
            counts["turn fits"] += all(fitting)
        counts["mentions"] += len(fitting)
        counts["mention fits"] += sum(fitting)


if __name__ == "__main__":
    sys.exit(main())
