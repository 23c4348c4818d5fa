"""An episode's own furniture, and distracter furniture."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arramon_dataset.layout.prop_places import PATH_GAP
from arramon_dataset.release.files import read_release
from arramon_dataset.release.importer import add_objects, walked_positions
from arramon_dataset.release.landmarks.distracters import NAMED_KIND_GAP
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, FurnitureGrid
from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.rebuilt_section import named_and_moved_furniture, rebuild_section
from arramon_dataset.release.landmarks.recovery import TurnText, turn_texts
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.provenance import DRAWN, TEXT, Provenance
from arramon_server.sim.assets.furniture import footprint_radius
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.section import ON_WALLS, Prop, Section
from benchmarks.release.drawn_furniture import reconstruct

SAMPLE = Path(__file__).parents[4] / "examples" / "sample" / "sample.json"

TEXTS = {
    "en": (
        Instructions("Go past the cone to the blue phone booth. Pick up the ball beside the bench.", "Place it."),
        Instructions("Turn around at the dumpster. Pick up the mug in front of the lamp post.", "Place it."),
    )
}


@pytest.fixture(scope="module")
def episodes() -> list[Episode]:
    _, listed = read_release(SAMPLE)
    first = [replace(each, instructions=TEXTS) for each in listed if each.section == listed[0].section]
    return [add_objects(episode, walked_positions(first)) for episode in first]


@pytest.fixture(scope="module")
def section(episodes: list[Episode]) -> Section:
    turns = [turn for episode in episodes for turn in episode.turns]
    targets = np.array([(turn.target.position.x, turn.target.position.z) for turn in turns])
    return reconstruct(episodes[0].section, [np.array(turn.path) for turn in turns], targets)


@pytest.fixture(scope="module")
def rebuilt(section: Section, episodes: list[Episode]) -> tuple[Section, list[Episode], Provenance]:
    return rebuild_section(section, episodes)


def space_of(episode: Episode, section: Section, episodes: list[Episode]) -> FreeSpace:
    walked = np.concatenate([np.array(turn.path) for each in episodes for turn in each.turns])
    return FreeSpace.of(episode, FurnitureGrid.of(section.heading, section.buildings, walked))


def test_the_same_episodes_give_the_same_world(
    section: Section, episodes: list[Episode], rebuilt: tuple[Section, list[Episode], Provenance]
) -> None:
    again, furnished_again, provenance = rebuild_section(section, episodes[::-1])
    assert (again, furnished_again[::-1], provenance) == rebuilt


def test_nothing_stands_on_an_episodes_own_path(
    section: Section, episodes: list[Episode], rebuilt: tuple[Section, list[Episode], Provenance]
) -> None:
    world, furnished_episodes, _ = rebuilt
    for episode in furnished_episodes:
        space = space_of(episode, section, episodes)
        for prop in furnished(world, episode.furniture).props:
            if prop.kind not in ON_WALLS:
                apart = np.hypot(*(space.walked - (prop.x, prop.z)).T).min()
                assert apart >= PATH_GAP + footprint_radius(prop.kind) - 0.01, prop


def test_what_nobody_spoke_of_is_of_kinds_that_nobody_named_near_the_path(
    section: Section, episodes: list[Episode], rebuilt: tuple[Section, list[Episode], Provenance]
) -> None:
    _, furnished_episodes, provenance = rebuilt
    distracters = 0
    for episode in furnished_episodes:
        named = {event.kind for each in turn_texts(episode) for event in each.events}
        space = space_of(episode, section, episodes)
        for prop, origin in zip(episode.furniture.added, provenance.own.get(episode.episode_id, ()), strict=True):
            assert origin in (TEXT, DRAWN)
            if origin == DRAWN:
                distracters += 1
                near = np.hypot(*(space.walked - (prop.x, prop.z)).T).min()
                assert prop.kind not in named or near > NAMED_KIND_GAP - 0.5
            else:
                assert prop.kind in named
    assert distracters


def test_a_thing_that_both_turns_name_at_one_place_is_one_thing(section: Section, episodes: list[Episode]) -> None:
    episode = episodes[0]
    space = space_of(episode, section, episodes)
    first, second = (each for each in turn_texts(episode) if each.language == "en")
    at_end = replace(first, events=(Event(kind="hydrant", manner="target", relation="near", identity="1"),))
    at_start = replace(second, path=replace(second.path, target=first.path.target), events=(*at_end.events,))
    bare = replace(section, props=())

    def hydrants(texts: list[TurnText]) -> list[Prop]:
        return [
            prop
            for prop in named_and_moved_furniture(episode.episode_id, texts, bare, space, []).added
            if prop.kind == "hydrant"
        ]

    (one,) = hydrants([at_end, at_start])
    assert np.hypot(*(first.path.target - (one.x, one.z))) < 4.0
    assert len(hydrants([at_end, replace(second, events=at_end.events)])) == 2 or _near(first, second)


def _near(first: TurnText, second: TurnText) -> bool:
    return bool(np.hypot(*(first.path.target - second.path.target)) < 4.0)
