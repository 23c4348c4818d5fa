"""Distracters and decoys that imported episodes get: number, places, likeness to the target, reproducibility."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import arramon_lang as lang
from arramon_dataset.release.missing_objects import (
    DECOYS,
    Points,
    arrange_decoys,
    draw_distracters,
    read_references,
    shared_attributes,
)
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.room import START, RoomCell, RoomPosition

PLAZA: Points = np.array([(x, z) for x in range(30) for z in range(30)], dtype=float)
TARGET = ObjectType("striped", "red", "mug")
FIRST, SECOND = TARGET, ObjectType("dotted", "white", "book")
ENGLISH = lang.load("en")
Placements = tuple[RoomPosition, RoomPosition]
Walks = tuple[list[RoomCell], list[RoomCell]]


def drawn(episode_id: str, path: Points, ground: Points = PLAZA) -> tuple[tuple[ObjectType, Point], ...]:
    end = Pose(float(path[-1][0]), float(path[-1][1]), 0.0)
    target = end.ahead(1.5)
    return draw_distracters(episode_id, 1, TARGET, Point(target.x, 0.1, target.z), path, end, ground)


def room(
    placements: Placements,
    texts: tuple[str, str] = ("", ""),
    walks: Walks = ([START], [START]),
    episode_id: str = "7",
) -> dict[RoomCell, ObjectType]:
    references = (read_references(texts[0], ENGLISH), read_references(texts[1], ENGLISH))
    found = arrange_decoys(episode_id, (FIRST, SECOND), placements, walks, references)
    assert len({cell for _, cell in found}) == len(found)
    return {cell: kind for kind, cell in found}


@settings(max_examples=60)
@given(st.text(max_size=8), st.lists(st.tuples(st.integers(0, 29), st.integers(0, 29)), min_size=1, max_size=9))
def test_distracters_keep_away_from_path_target_and_each_other(episode_id: str, corners: list[tuple[int, int]]) -> None:
    path = np.array(corners, dtype=float)
    end = Pose(float(path[-1][0]), float(path[-1][1]), 0.0)
    dense = np.concatenate(
        [np.linspace(a, b, 60) for a, b in zip(path, np.roll(path, -1, axis=0), strict=True)][:-1] or [path]
    )
    found = drawn(episode_id, path)

    assert len(found) <= 7
    for kind, place in found:
        assert 1 <= len(shared_attributes(TARGET, kind)) <= 2
        assert (place.x, place.z) in set(map(tuple, PLAZA))
        assert place.y == 0.0
        assert np.hypot(*(dense - (place.x, place.z)).T).min() >= 1.2
        assert math.dist((place.x, place.z), (end.x, end.z + 1.5)) >= 2.0
        right, ahead = end.local(place.x, place.z)
        assert not (abs(right) <= 0.65 and -0.15 <= ahead <= 3.15)
    for i, (kind, place) in enumerate(found):
        for other_kind, other in found[:i]:
            assert kind != other_kind
            assert math.dist(place, other) >= 1.0


def test_five_to_seven_distracters_are_drawn_mostly_near_the_path() -> None:
    path = np.array([(15.0, z) for z in range(4, 12)])
    counts, shared, near = set(), set(), []
    for number in range(40):
        found = drawn(str(number), path)
        counts.add(len(found))
        for kind, place in found:
            shared.add(shared_attributes(TARGET, kind))
            near.append(3.0 <= np.hypot(*(path - (place.x, place.z)).T).min() <= 12.0)

    assert counts == {5, 6, 7}
    assert len(shared) == 6
    assert 0.6 < sum(near) / len(near) < 1.0


def test_distracters_are_determined_by_episode_id_and_turn() -> None:
    path, end = np.array([(15.0, 10.0), (15.0, 11.0)]), Pose(15.0, 11.0, 0.0)

    def draw(episode_id: str, turn: int) -> tuple[tuple[ObjectType, Point], ...]:
        return draw_distracters(episode_id, turn, TARGET, Point(15.0, 0.1, 12.5), path, end, PLAZA)

    assert draw("1", 1) == draw("1", 1)
    assert draw("1", 1) != draw("2", 1)
    assert draw("1", 1) != draw("1", 2)


@pytest.mark.parametrize(
    ("ground", "most"),
    [(np.zeros((0, 2)), 0), (np.array([[15.0, 10.5]]), 0), (np.array([[0.0, 0.0], [0.5, 0.0], [9.0, 9.0]]), 2)],
)
def test_little_free_ground_gives_fewer_distracters(ground: Points, most: int) -> None:
    assert len(drawn("1", np.array([(15.0, 10.0), (15.0, 11.0)]), ground)) == most


cells = st.builds(RoomCell, st.integers(1, 4), st.integers(0, 3)).filter(lambda cell: cell != START)
placements = st.builds(lambda cell, level: RoomPosition(cell.column, level, cell.row), cells, st.integers(1, 2))
walks = st.lists(st.builds(RoomCell, st.integers(1, 4), st.integers(0, 2)), max_size=4)


@given(st.text(max_size=5), placements, placements, walks, walks)
def test_decoys_avoid_the_start_the_paths_and_floor_targets(
    episode_id: str, first: RoomPosition, second: RoomPosition, walk: list[RoomCell], other_walk: list[RoomCell]
) -> None:
    places = (first, second)
    stands = {RoomCell(place.column, place.row) for place in places if place.level == 2}
    floor = {RoomCell(place.column, place.row) for place in places if place.level == 1}
    found = room(places, walks=([START, *walk], [START, *other_walk]), episode_id=episode_id)

    assert len(found) == DECOYS
    assert len(set(found.values()) - {FIRST, SECOND}) == DECOYS
    assert not set(found) & ({START, *walk, *other_walk, *floor} - stands)
    assert all(cell.is_inside() for cell in found)
    if RoomCell(second.column, second.row) in stands - floor:
        assert RoomCell(second.column, second.row) in found


@pytest.mark.parametrize(
    ("first", "second", "stands"),
    [
        ((3, 1, 3), (3, 2, 3), []),
        ((3, 2, 3), (1, 1, 2), [(3, 3)]),
        ((3, 1, 3), (1, 2, 2), [(1, 2)]),
        ((3, 2, 3), (3, 2, 2), [(3, 3), (3, 2)]),
    ],
)
def test_decoys_are_only_under_targets_that_need_support(
    first: tuple[int, int, int], second: tuple[int, int, int], stands: list[tuple[int, int]]
) -> None:
    for number in range(20):
        found = room((RoomPosition(*first), RoomPosition(*second)), episode_id=str(number))

        targets = {(first[0], first[2]), (second[0], second[2])}
        assert targets & set(found) == {RoomCell(*cell) for cell in stands}


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Put it on top of the striped blue mug.", "striped blue mug"),
        ("Put the red mug on top of the striped blue ball to the left of the dotted red tv.", "striped blue ball"),
        ("Place it on top of the other striped red mug.", "striped red mug"),
        ("Put the striped red mug on top of the dotted purple hourglas.", "dotted purple hourglass"),
    ],
)
def test_decoy_under_a_target_is_the_named_object(text: str, name: str) -> None:
    found = room((RoomPosition(3, 2, 3), RoomPosition(1, 1, 1)), (text, ""))

    assert str(found[RoomCell(3, 3)]) == name


def test_incomplete_decoy_name_is_completed_at_random() -> None:
    kinds = {
        room((RoomPosition(3, 2, 3), RoomPosition(1, 1, 1)), ("Put it on top of the blue mug.", ""), episode_id=str(i))[
            RoomCell(3, 3)
        ]
        for i in range(20)
    }

    assert {(kind.colour, kind.kind) for kind in kinds} == {("blue", "mug")}
    assert len(kinds) == 2


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("Put it to the left of the dotted green ball.", (3, 2)),
        ("Put it to the right of the dotted green ball.", (1, 2)),
        ("Put it behind the dotted green ball.", (2, 1)),
        ("Put it in front of the dotted green ball.", (2, 3)),
    ],
)
def test_mentioned_object_is_placed_as_the_instruction_says(text: str, cell: tuple[int, int]) -> None:
    found = room((RoomPosition(2, 1, 2), RoomPosition(4, 1, 0)), (text, ""))

    assert found[RoomCell(*cell)] == ObjectType("dotted", "green", "ball")


def test_mentioned_object_moves_nearby_if_its_cell_is_taken() -> None:
    walk = [START, RoomCell(2, 1)]
    found = room(
        (RoomPosition(2, 1, 2), RoomPosition(4, 1, 0)), ("Put it behind the dotted green ball.", ""), (walk, [START])
    )

    assert {cell for cell, kind in found.items() if str(kind) == "dotted green ball"} <= {(1, 2), (3, 2), (2, 3)}


def test_targets_are_never_decoys() -> None:
    text = f"Put the {SECOND} to the left of the {FIRST}."
    found = room((RoomPosition(2, 1, 2), RoomPosition(1, 1, 2)), ("", text))

    assert not {FIRST, SECOND} & set(found.values())


def test_decoys_are_determined_by_the_episode_id() -> None:
    places = (RoomPosition(2, 1, 2), RoomPosition(4, 1, 0))

    assert room(places, episode_id="1") == room(places, episode_id="1")
    assert room(places, episode_id="1") != room(places, episode_id="2")


def test_a_crowded_room_holds_fewer_decoys() -> None:
    everywhere = [RoomCell(column, row) for column in range(5) for row in range(4)]
    found = room((RoomPosition(3, 2, 3), RoomPosition(1, 1, 1)), walks=(everywhere, []))

    assert set(found) == {RoomCell(3, 3)}
    assert set(found.values()) <= set(ALL_TYPES)
