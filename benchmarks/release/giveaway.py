"""How far furniture alone reveals the target: `python -m benchmarks.release.giveaway DATA --split val_seen`.

People name what stands near their path. If nothing else stood in an episode, a follower that reads nothing could walk
towards furniture. Prints, with all furniture of an episode and with what its own texts name alone: how often the object
in the street with the most furniture beside it is the target, against chance; how often a walker that goes to the place
with the most furniture, of all places as far from its start as the target is, comes within 3 units of the target,
against one that goes to any of these places; and how dense furniture is along the path, against elsewhere.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from arramon_dataset.release.importer import walked_positions
from arramon_dataset.release.landmarks.distracters import AROUND
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, FurnitureGrid
from arramon_dataset.release.landmarks.mentions import DRAWN
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.provenance import TEXT
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.sim.section import Prop
from benchmarks.common import parser_of

Numbers = npt.NDArray[np.float64]

BESIDE_DISTANCE, NEAR_DISTANCE, ARRIVAL_DISTANCE = 2.2, 3.0, 3.0
"""Maximum distances in units: of furniture beside an object, of furniture near a place, of the target on arrival."""

START_DISTANCE_RANGE = (0.75, 1.33)
"""Range of the distance from the start, relative to the target's, of the places among which a walker chooses."""


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="data folder of `arramon-server import-release`")
    parser.add_argument("--split", default="val_seen", help="one of its splits (default: %(default)s)")
    arguments = parser.parse_args()
    split = read_splits(arguments.data)[arguments.split]
    for name, own_alone in (("all furniture", False), ("named alone", True)):
        counts = count_guesses(split, own_alone=own_alone)
        turns = counts["turns"]
        print(
            f"{name:14}{turns:g} turns  most furniture beside it: target {counts['target'] / turns:.3f}, "
            f"chance {counts['chance'] / turns:.3f}  walker {counts['walker'] / turns:.3f}, "
            f"chance {counts['any place'] / turns:.3f}  things a hundred places: at the path "
            f"{100 * counts['at path'] / counts['places at path']:.2f}, "
            f"elsewhere {100 * counts['elsewhere'] / counts['places elsewhere']:.2f}"
        )


def count_guesses(split: Split, *, own_alone: bool) -> dict[str, float]:
    """Return sums of right guesses over a split's turns, with all furniture, or only what the episode's texts name."""
    counts: dict[str, float] = defaultdict(float)
    for section in split.sections.values():
        episodes = [episode for episode in split.episodes.values() if episode.section == section.id]
        ground = FurnitureGrid.of(section.heading, section.buildings, walked_positions(episodes))
        walkable = cKDTree(walked_positions(episodes))
        for episode in episodes:
            origins = split.provenance[section.id].own.get(episode.episode_id, ())
            added = zip(episode.furniture.added, origins, strict=True)
            props = [p for p, origin in added if p.kind in DRAWN and (origin == TEXT or not own_alone)]
            _count(counts, episode, props, FreeSpace.of(episode, ground), np.asarray(walkable.data))
    return counts


def _count(
    counts: dict[str, float], episode: Episode, props: Sequence[Prop], space: FreeSpace, walkable: Numbers
) -> None:
    things = np.array([(prop.x, prop.z) for prop in props]).reshape(-1, 2)
    at_path = sum(np.hypot(*(space.walked - thing).T).min() <= AROUND for thing in things)
    near = int((space.from_path <= AROUND).sum())
    sums = {"at path": at_path, "elsewhere": len(things) - at_path}
    sums |= {"places at path": near, "places elsewhere": len(space.from_path) - near}
    for name, number in sums.items():
        counts[name] += number
    for turn in episode.turns:
        objects = np.array([(each.position.x, each.position.z) for each in turn.street])
        beside = _around(objects, things, BESIDE_DISTANCE)
        best = beside == beside.max()
        far = math.dist(turn.path[0], objects[0])
        distances = np.hypot(*(walkable - turn.path[0]).T)
        places = walkable[(distances >= START_DISTANCE_RANGE[0] * far) & (distances <= START_DISTANCE_RANGE[1] * far)]
        furnished = _around(places, things, NEAR_DISTANCE)
        arrived = np.hypot(*(places - objects[0]).T) < ARRIVAL_DISTANCE
        counts["turns"] += 1
        counts["target"] += best[0] / best.sum()
        counts["chance"] += 1.0 / len(objects)
        counts["walker"] += float(arrived[furnished == furnished.max()].mean()) if len(places) else 0.0
        counts["any place"] += float(arrived.mean()) if len(places) else 0.0


def _around(places: Numbers, things: Numbers, within: float) -> Numbers:
    """Return the number of things within a distance of each place, (n,)."""
    if not len(places) or not len(things):
        return np.zeros(len(places))
    found: Numbers = (np.hypot(*(places[:, None] - things[None]).transpose(2, 0, 1)) <= within).sum(axis=1)
    return found


if __name__ == "__main__":
    main()
