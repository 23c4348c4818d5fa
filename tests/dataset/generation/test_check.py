"""Validation of drafts: each fault is reported."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from arramon_client.world import Action
from arramon_dataset.generation import Draft, GenerationSite, faults_of_episode
from arramon_dataset.generation.navigation_tasks import TWIN_PATH, TWINS_APART
from arramon_dataset.plans import build_section, read_plan
from arramon_dataset.release.missing_objects import distance_to_path
from arramon_server.sim.geometry import Point
from arramon_server.sim.room import START, RoomPosition
from arramon_server.sim.rules import PlacedObject


@pytest.fixture(scope="module")
def site() -> Iterator[GenerationSite]:
    made = GenerationSite(build_section(read_plan("6"), "test"))
    yield made
    made.physics.close()


@pytest.fixture(scope="module")
def draft(site: GenerationSite) -> Draft:
    return site.sampler.draw("1", ("check", 3))


def test_sampled_drafts_have_no_problems(site: GenerationSite) -> None:
    for i in range(20):
        assert faults_of_episode(site.sampler.draw(str(i), ("passes", i)), site.solids, site.physics) == ()


def test_drafts_are_determined_by_their_seed_names(site: GenerationSite) -> None:
    assert (
        site.sampler.draw("1", ("a",))
        == GenerationSite(site.section).sampler.draw("1", ("a",))
        != site.sampler.draw("1", ("b",))
    )


def test_another_object_like_the_target_lies_off_the_way_and_nearer(site: GenerationSite) -> None:
    found = 0
    for i in range(20):
        draft = site.sampler.draw(str(i), ("twins", i))
        for turn in draft.turns:
            target, *others = turn.street
            for twin in (other for other in others if other.type == target.type):
                found += 1
                place = np.array([(twin.position.x, twin.position.z)])
                apart = math.hypot(twin.position.x - target.position.x, twin.position.z - target.position.z)
                assert apart >= TWINS_APART
                assert distance_to_path(place, np.array(turn.path))[0] >= TWIN_PATH
    assert 8 <= found <= 36  # Of 40 turns three in four may have one.


def of_turn(draft: Draft, number: int, **changes: object) -> Draft:
    turns = list(draft.turns)
    turns[number - 1] = replace(turns[number - 1], **changes)  # type: ignore[arg-type]
    return replace(draft, turns=(turns[0], turns[1]))


def moved_to_a_building(draft: Draft, site: GenerationSite) -> Draft:
    street = draft.turns[1].street
    inside = site.section.buildings[0]
    item = replace(street[-1], position=Point(inside.x, 0.0, inside.z))
    return of_turn(draft, 2, street=(*street[:-1], item))


def beside_the_target(draft: Draft, site: GenerationSite) -> Draft:
    target, *others = draft.turns[0].street
    near = replace(target, position=target.position._replace(x=target.position.x + 2.0))
    return of_turn(draft, 1, street=(target, *others[:-1], near))


def twice_a_distracter(draft: Draft, site: GenerationSite) -> Draft:
    street = draft.turns[0].street
    return of_turn(draft, 1, street=(*street[:-1], replace(street[-1], type=street[-2].type)))


def in_one_place(draft: Draft, site: GenerationSite) -> Draft:
    street = draft.turns[0].street
    return of_turn(draft, 1, street=(*street[:-1], replace(street[-1], position=street[1].position)))


def decoy_on(draft: Draft, cell: RoomPosition) -> Draft:
    return replace(draft, decoys=(*draft.decoys[:-1], replace(draft.decoys[-1], placement=cell)))


CASES: list[tuple[Callable[[Draft, GenerationSite], Draft], str]] = [
    (moved_to_a_building, "turn 2: .* inside something solid"),
    (beside_the_target, "turn 1: two objects are a"),
    (twice_a_distracter, "turn 1: two objects are a"),
    (in_one_place, "turn 1: .* too close"),
    (lambda d, _: replace(d, start=replace(d.start, heading=d.start.heading + 1)), "turn 1, navigation"),
    (lambda d, s: replace(d, start=replace(d.start, x=s.section.buildings[0].x, z=s.section.buildings[0].z)), "start"),
    (lambda d, _: of_turn(d, 1, actions=d.turns[0].actions[:-1]), "turn 1, navigation: not ended"),
    (lambda d, _: of_turn(d, 2, actions=(*d.turns[1].actions, Action.LEFT)), "turn 2, navigation: ended before"),
    (lambda d, _: of_turn(d, 1, path=d.turns[0].path[:-1]), "turn 1, navigation: .* follow the path"),
    (lambda d, _: of_turn(d, 2, room_path=(*d.turns[1].room_path, START)), "turn 2, assembly: .* follow the path"),
    (lambda d, _: of_turn(d, 2, target_cell=RoomPosition(0, 1, 0)), "turn 2, assembly: does not end with"),
    (lambda d, _: of_turn(d, 1, actions=(Action.LEFT,) * 3 + (Action.FORWARD,) * 140), "turn 1, navigation"),
    (lambda d, _: replace(d, decoys=d.decoys[:-1]), "7 decoys, expected 8"),
    (lambda d, _: decoy_on(d, d.decoys[0].placement), "each in a cell of its own"),
    (lambda d, _: decoy_on(d, RoomPosition(2, 1, 0)), "start tile"),
    (lambda d, _: decoy_on(d, RoomPosition(5, 1, 0)), "outside the room"),
    (
        lambda d, _: replace(d, decoys=(*d.decoys[:-1], PlacedObject(d.turns[0].target.type, d.decoys[-1].placement))),
        "look the same",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("spoil", "expected"), CASES, ids=[expected for _, expected in CASES])
def test_faulty_drafts_are_reported(
    draft: Draft, site: GenerationSite, spoil: Callable[[Draft, GenerationSite], Draft], expected: str
) -> None:
    assert faults_of_episode(draft, site.solids, site.physics) == ()
    found = "\n".join(faults_of_episode(spoil(draft, site), site.solids, site.physics))

    assert re.search(expected, found), found
