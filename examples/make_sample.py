"""Generator of the sample in `examples/sample`: 24 episodes in two invented sections, in the release's format.

    python -m examples.make_sample [--output DIR]

It contains nothing of the release. The same program gives the same bytes on every machine.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

from arramon_client.world import CELL_SIZE, EYE_HEIGHT
from arramon_dataset.randomness import seeded
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from examples.sampling import english, hindi
from examples.sampling.rooms import Order, draw_orders
from examples.sampling.routes import RouteLeg, legs_of, side_of
from examples.sampling.town import TOWNS, Spot, Town, TownPoint, find_way

EPISODES = 12
"""Number of episodes in each town."""

LENGTHS = range(15, 46)
"""Range of forward steps in a turn."""

TURNS = (0, 1)
LETTERS = "flrP"
PICK_UP = 3
OBJECT_HEIGHT = 0.06
ROOM = (100.0, -50.0, -20.0)
"""Position of the start tile in the file's coordinates; arbitrary, as in the release."""

Walk = tuple[list[Spot], list[int], TownPoint]
"""The poses after each action, the actions, and the target's position."""


def main() -> None:
    """Write both files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "sample", help="folder to write to")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    pairs = [pair for town in TOWNS for pair in make_episodes(town)]
    for index, name in enumerate(("sample.json", "sample_hindi.json")):
        lines = [json.dumps(pair[index], ensure_ascii=False, sort_keys=True) for pair in pairs]
        (output / name).write_bytes(("[\n" + ",\n".join(lines) + "\n]\n").encode())


def make_episodes(town: Town) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return the town's episodes, each in English and in Hindi, spread over all its streets."""
    covered: list[TownPoint] = []
    pairs = []
    for number in range(EPISODES):
        map_id = town.first_map_id + 37 * number
        random = seeded("sample", map_id)
        targets = tuple(random.sample(ALL_TYPES, 2))
        walks = draw_walks(town, covered, random)
        orders = draw_orders((targets[0], targets[1]), stacked=number % 6 == 3, random=random)
        record = write_record(town, map_id, targets, walks, orders)
        pairs.append(
            tuple({**record, "instructions": texts} for texts in write_texts(town, targets, walks, orders, random))
        )
    return [(english_record, hindi_record) for english_record, hindi_record in pairs]


def draw_walks(town: Town, covered: list[TownPoint], random: Random) -> list[Walk]:
    """Draw two walks, the second from the end of the first, away from `covered` places; add theirs to `covered`."""
    while True:
        start = max(random.sample(town.spots, 10), key=lambda place: apart(place, covered))
        heading = random.choice((0, 0, 6, 3, 9))
        spot = Spot((2 * int(start.across), 0), (2 * int(start.along), 0), heading)
        walks: list[Walk] = []
        for _ in TURNS:
            walk = draw_walk(town, spot, covered, random)
            if walk is None:
                break
            walks.append(walk)
            spot = walk[0][-1]
        else:
            covered += [spot.place for walk in walks for spot in walk[0]]
            return walks


def draw_walk(town: Town, start: Spot, covered: Sequence[TownPoint], random: Random) -> Walk | None:
    """Draw a describable walk of suitable length to a target far from `covered` places; None if there is none."""
    far = town.distances(start.place)
    targets = [spot for spot in town.spots if 17 <= far.get((int(spot.across), int(spot.along)), 0) <= 40]
    targets = random.sample(targets, min(16, len(targets)))
    for target in sorted(targets, key=lambda place: -apart(place, covered)):
        found = find_way(town, start, target)
        if found is None:
            continue
        spots, actions = found
        if actions.count(0) + 1 in LENGTHS and actions.count(0) in LENGTHS and legs_of(town, spots, target):
            return spots, [*actions, PICK_UP], target
    return None


def apart(place: TownPoint, others: Sequence[TownPoint]) -> float:
    """Return the squared distance from a place to the nearest of the others; 0 if there are none."""
    return min(((place.across - o.across) ** 2 + (place.along - o.along) ** 2 for o in others), default=0.0)


def write_texts(
    town: Town, targets: Sequence[ObjectType], walks: Sequence[Walk], orders: Sequence[Order], random: Random
) -> list[dict[str, list[str]]]:
    """Return the `instructions` of an episode in English and in Hindi."""
    written = []
    for language in (english, hindi):
        navigation = []
        for target, (spots, _, place) in zip(targets, walks, strict=True):
            legs: list[RouteLeg] = legs_of(town, spots, place) or []
            navigation.append(language.navigate(legs, target, side_of(town, place, spots), random))
        assembly = [language.assemble(order, target, random) for order, target in zip(orders, targets, strict=True)]
        written.append({"navi_inst_gt": navigation, "assem_inst_gt": assembly})
    return written


def write_record(
    town: Town, map_id: int, targets: Sequence[ObjectType], walks: Sequence[Walk], orders: Sequence[Order]
) -> dict[str, Any]:
    """Return the episode in the release's format, without its instructions."""
    navigation = [actions for _, actions, _ in walks]
    assembly = [list(order.actions) for order in orders]
    return {
        "mapId": map_id,
        "code": "SAMPLE",
        "filename": f"sample_{map_id}.json",
        "gt_objects": [str(target).title().replace("Tv", "TV") for target in targets],
        "gt_objects_pos": {
            "navi_obj_pos_gt": [at_height(town, place, OBJECT_HEIGHT) for _, _, place in walks],
            "assem_obj_pos_gt": [list(order.placement) for order in orders],
        },
        "gt_paths": {
            "navi_path_gt": [
                [at_height(town, place, EYE_HEIGHT) for place in dict.fromkeys(spot.place for spot in spots)]
                for spots, _, _ in walks
            ],
            "assem_path_gt": [
                [
                    [ROOM[0] + CELL_SIZE * (cell.column - 2), ROOM[1], ROOM[2] + CELL_SIZE * cell.row]
                    for cell in order.path
                ]
                for order in orders
            ],
        },
        "gt_actionIDs": {"navi_actionIDs_gt": navigation, "assem_actionIDs_gt": assembly},
        "gt_actions": {
            "navi_action_gt": [spelt(navigation[turn], turn) for turn in TURNS],
            "assem_action_gt": [spelt(assembly[turn], turn) for turn in TURNS],
        },
    }


def at_height(town: Town, place: TownPoint, height: float) -> list[float]:
    """Return a place of the town as [x, y, z]."""
    x, z = town.world(place)
    return [x, height, z]


def spelt(actions: Sequence[int], turn: int) -> list[str]:
    """Return actions as letters, followed by the turn's number."""
    return [*(LETTERS[action] for action in actions), str(turn)]


if __name__ == "__main__":
    main()
