"""How often held-out texts name things that the rebuilt city has: `python -m benchmarks.release.landmarks FILE`.

Recovers each section's fixed scenery with a part of its episodes held out (`--folds 2`: half of them), places the
held-out episodes' own furniture by their own texts, and counts their mentions and turns that fit: each named thing
exists (with its kind, and the stated colour and side) within 4 units of where the text's alignment in that world puts
it. Baselines: the same scenery with permuted kinds, all furniture at random places of the same ground, and furniture
drawn without texts. "seen" is the share of fitting things that the camera shows in one of the steps up to their
mention.
"""

from collections import Counter, defaultdict
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import repeat
from pathlib import Path

import numpy as np

from arramon_dataset.randomness import seeded
from arramon_dataset.release.files import read_release
from arramon_dataset.release.importer import add_objects, walked_positions
from arramon_dataset.release.landmarks.agreement import landmarks_by_kind, mentions_of, placed_things
from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, FurnitureGrid
from arramon_dataset.release.landmarks.mentions import SCENERY
from arramon_dataset.release.landmarks.rebuilt_section import KNOWN, named_and_moved_furniture
from arramon_dataset.release.landmarks.recovery import LandmarkMap, RecoveredLandmark, TurnText, recover, turn_texts
from arramon_dataset.release.landmarks.scenery import props_of
from arramon_dataset.release.landmarks.turn_paths import Numbers
from arramon_server.episodes.episode import Episode
from arramon_server.sim.cameras import Viewpoint
from arramon_server.sim.city import city_scene, label_of_prop
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.section import Prop, Section
from benchmarks.common import add_json, parser_of, positive_int, write_json
from benchmarks.release.drawn_furniture import reconstruct

STEPS_BEFORE = 6
"""Number of steps before a mention's place in which its thing may be visible."""

SIZE, PIXELS = 224, 6
"""Side length of frames, and minimum number of pixels of a visible label."""

Counts = dict[str, Counter[str]]
"""Numbers of turns, fitting turns, mentions and fitting mentions by kind, for each world."""


def main() -> None:
    """Run the benchmark and print its tables."""
    parser = parser_of(__doc__)
    parser.add_argument("file", type=Path, help="a file of the official release")
    parser.add_argument("--lang", help="code of the file's language; without it detected from the texts")
    parser.add_argument("--folds", type=positive_int, default=5, help="parts of the episodes (default: %(default)s)")
    parser.add_argument(
        "--seen", type=int, default=10, help="render one in N episodes; 0 for none (default: %(default)s)"
    )
    add_json(parser)
    arguments = parser.parse_args()

    language, episodes = read_release(arguments.file, arguments.lang)
    by_section: dict[str, list[Episode]] = defaultdict(list)
    for episode in episodes:
        by_section[episode.section].append(episode)
    total: Counts = defaultdict(Counter)
    with ProcessPoolExecutor(2) as pool:
        measured = pool.map(measure, by_section, by_section.values(), repeat(arguments.folds), repeat(arguments.seen))
        for section, (counts, landmarks) in zip(by_section, measured, strict=True):
            print(f"section {section}: {len(by_section[section])} episodes, {landmarks:.1f} landmarks without a part")
            for world, numbers in counts.items():
                total[world].update(numbers)
                print(f"  {world:12}{_line(numbers)}", flush=True)
    print(f"all, {language}")
    for world, numbers in total.items():
        print(f"  {world:12}{_line(numbers)}")
    print("by kind: mentions that fit, with kinds permuted in brackets, number of mentions")
    for kind in sorted({name.split()[1] for name in total["held out"] if name.startswith("all ")}):
        shares = [total[w][f"fits {kind}"] / max(1, total[w][f"all {kind}"]) for w in ("held out", "permuted")]
        print(f"  {kind:14}{shares[0]:.2f} ({shares[1]:.2f}) {total['held out'][f'all {kind}']}")
    write_json(arguments.json, {world: dict(numbers) for world, numbers in total.items()})


def _line(numbers: Counter[str]) -> str:
    def share(part: str, whole: str) -> str:
        return f"{numbers[part] / max(1, numbers[whole]):.3f} of {numbers[whole]}"

    seen = f", seen {share('seen', 'drawn')}" if numbers["drawn"] else ""
    return (
        f"turns that fit {share('turn fits', 'turns')}, mentions {share('mention fits', 'mentions')}, "
        f"of scenery {share('scenery fits', 'scenery')}{seen}"
    )


def measure(section_id: str, episodes: Sequence[Episode], folds: int, seen: int) -> tuple[Counts, float]:
    """Return the counts of a section's worlds, and the mean number of landmarks recovered from the other episodes."""
    grounded = walked_positions(episodes)
    episodes = [add_objects(episode, grounded) for episode in episodes]
    paths = [np.array(turn.path) for episode in episodes for turn in episode.turns]
    targets = np.array([(t.target.position.x, t.target.position.z) for e in episodes for t in e.turns])
    section, walked = reconstruct(section_id, paths, targets), np.concatenate(paths)
    ground = FurnitureGrid.of(section.heading, section.buildings, walked)
    all_texts = {episode.episode_id: turn_texts(episode) for episode in episodes}
    counts: Counts = defaultdict(Counter)
    found = 0
    for fold in range(folds):
        part = episodes[fold::folds]
        held_out = {episode.episode_id for episode in part}
        landmarks = recover([each for name, listed in all_texts.items() if name not in held_out for each in listed])
        found += len(landmarks)
        worlds = {
            name: _with(listed, section, ground, walked)
            for name, listed in (("held out", landmarks), ("permuted", permuted(landmarks, section_id, fold)))
        }
        for number, episode in enumerate(part):
            texts, space = all_texts[episode.episode_id], FreeSpace.of(episode, ground)
            for name, (world, made_from) in worlds.items():
                own = named_and_moved_furniture(episode.episode_id, texts, world, space, made_from)
                as_it_is = furnished(world, own)
                drawn = as_it_is if name == "held out" and seen and number % seen == 0 else None
                _count(counts[name], texts, as_it_is.props, drawn)
                if name == "held out":
                    _count(counts["random"], texts, scattered(episode.episode_id, as_it_is.props, ground))
            _count(counts["before"], texts, section.props)
    return counts, found / folds


def permuted(landmarks: Sequence[RecoveredLandmark], *names: object) -> list[RecoveredLandmark]:
    """Return the landmarks with their kinds, colours and looks permuted among their places."""
    looks = [(each.kind, each.colour, each.look, each.names) for each in landmarks]
    seeded(*names, "permuted").shuffle(looks)
    pairs = zip(landmarks, looks, strict=True)
    return [
        replace(each, kind=kind, colour=colour, look=look, names=called) for each, (kind, colour, look, called) in pairs
    ]


def _with(
    landmarks: Sequence[RecoveredLandmark], section: Section, ground: FurnitureGrid, walked: Numbers
) -> tuple[Section, list[RecoveredLandmark]]:
    """Return the section with landmarks, and the landmark of each of its props."""
    built = props_of(landmarks, section.heading, section.buildings, ground, walked)
    return replace(section, props=tuple(prop for prop, _ in built)), [landmark for _, landmark in built]


def scattered(episode_id: str, props: Sequence[Prop], ground: FurnitureGrid) -> list[Prop]:
    """Return the props at random places."""
    random = seeded(episode_id, "scattered")
    places = [ground.places[random.randrange(len(ground.places))] for _ in props]
    return [replace(prop, x=float(x), z=float(z)) for prop, (x, z) in zip(props, places, strict=True)]


def _count(
    counts: Counter[str], texts: Sequence[TurnText], props: Sequence[Prop], drawn: Section | None = None
) -> None:
    """Count the turns and mentions that fit a world, and, if it is rendered, those that the camera shows."""
    things = placed_things(props)
    known = LandmarkMap.of(landmarks_by_kind(things, KNOWN))
    camera = None if drawn is None else RasterCamera(city_scene(drawn))
    for each in texts:
        fitting = []
        if each.events:
            aligned = align(each.events, each.path, known.fit)
            for event, place, thing in mentions_of(each.events, aligned, each.path, things):
                fitting.append(thing >= 0)
                counts[f"all {event.recovered_kind}"] += 1
                counts[f"fits {event.recovered_kind}"] += thing >= 0
                counts["scenery"] += event.recovered_kind in SCENERY
                counts["scenery fits"] += event.recovered_kind in SCENERY and thing >= 0
                if camera is not None and thing >= 0:
                    counts["drawn"] += 1
                    counts["seen"] += is_seen(camera, each, place, props[thing])
        if fitting:
            counts["turns"] += 1
            counts["turn fits"] += all(fitting)
        counts["mentions"] += len(fitting)
        counts["mention fits"] += sum(fitting)


def is_seen(camera: RasterCamera, text: TurnText, place: int, prop: Prop) -> bool:
    """Return whether the camera shows a prop's label in its direction, in the steps up to a place of the walk."""
    label = camera.labels.index(str(label_of_prop(prop)))
    for at in range(max(0, place - STEPS_BEFORE), place + 1):
        (x, z), heading = text.path.places[at], float(text.path.going[at])
        frame = camera.render(Viewpoint(float(x), float(z), heading), (), SIZE, segmentation=True)
        assert frame.segmentation is not None
        if int((frame.segmentation == label).sum()) >= PIXELS:
            return True
    return False


if __name__ == "__main__":
    main()
