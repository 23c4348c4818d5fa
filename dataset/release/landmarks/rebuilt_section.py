"""The section rebuilt from its episodes' texts: recovered landmarks, own furniture, and distracter furniture."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from arramon_dataset.release.landmarks.agreement import landmarks_by_kind, placed_things
from arramon_dataset.release.landmarks.distracters import distracter_furniture
from arramon_dataset.release.landmarks.facades import paint_facades
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, FurnitureGrid
from arramon_dataset.release.landmarks.mentions import DRAWN as DRAWN_KINDS
from arramon_dataset.release.landmarks.own_furniture import furniture_mentions, move_off_paths, own_furniture
from arramon_dataset.release.landmarks.recovery import LandmarkMap, RecoveredLandmark, TurnText, recover, turn_texts
from arramon_dataset.release.landmarks.scenery import props_of
from arramon_dataset.release.landmarks.text_colours import recolour_landmarks
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.provenance import COLOUR, DRAWN, TEXT, Provenance, RecoveredLook
from arramon_server.sim.own_furniture import OwnFurniture, furnished
from arramon_server.sim.section import Prop, Section

KNOWN = 0.8
"""Strength of each thing of a world in the alignment of a text to that world."""


def rebuild_section(section: Section, episodes: Sequence[Episode]) -> tuple[Section, list[Episode], Provenance]:
    """Return a section with the landmarks on which its episodes' texts agree, and the episodes with own furniture.

    The same episodes, in whatever order, give the same result.

    Args:
        section: with buildings; its furniture, if any, is replaced.
        episodes: all of the section, with objects in their streets.
    """
    listed = sorted(episodes, key=lambda each: each.episode_id)
    walked = np.concatenate([np.array(turn.path) for episode in listed for turn in episode.turns])
    ground = FurnitureGrid.of(section.heading, section.buildings, walked)
    texts = {episode.episode_id: turn_texts(episode) for episode in listed}
    everything = [each for episode in listed for each in texts[episode.episode_id]]
    landmarks = recover(everything)
    built = props_of(landmarks, section.heading, section.buildings, ground, walked)
    kept = [landmark for _, landmark in built]
    buildings, facades = paint_facades(section.buildings, everything)
    rebuilt = replace(section, props=tuple(prop for prop, _ in built), buildings=buildings)
    spaces = {episode.episode_id: FreeSpace.of(episode, ground) for episode in listed}
    own = {name: named_and_moved_furniture(name, texts[name], rebuilt, space, kept) for name, space in spaces.items()}
    named_props = {name: [prop for prop in each.added if prop.kind in DRAWN_KINDS] for name, each in own.items()}
    furniture = {
        name: _with_distracters(name, own[name], named_props, texts[name], rebuilt, space)
        for name, space in spaces.items()
    }
    origins = {name: _origins(own[name], each) for name, each in furniture.items() if each.added}
    props = tuple(_recovered(number, landmark) for number, (_, landmark) in enumerate(built))
    provenance = Provenance(section.id, props, facades, origins)
    return rebuilt, [replace(each, furniture=furniture[each.episode_id]) for each in episodes], provenance


def named_and_moved_furniture(
    name: str, texts: Sequence[TurnText], section: Section, space: FreeSpace, landmarks: Sequence[RecoveredLandmark]
) -> OwnFurniture:
    """Return the furniture that an episode's texts name, and the section's props that it moves off its own paths.

    Args:
        name: the episode's id.
        texts: those of the episode.
        section: whose props are recovered landmarks.
        space: free ground of the episode.
        landmarks: from which each of the section's props was made.

    Returns:
        Landmarks in the colour that the texts say come first in `added`.
    """
    moved, left_out = move_off_paths(section.props, space)
    standing = furnished(section, OwnFurniture((), tuple(moved), tuple(left_out))).props
    there = [number for number in range(len(section.props)) if number not in left_out]
    renamed = recolour_landmarks(texts, standing, [landmarks[number] for number in there], KNOWN)
    replaced = {there[at] for at in renamed}
    changed = OwnFurniture(
        tuple(renamed.values()),
        tuple(each for each in moved if each.prop not in replaced),
        tuple(sorted({*left_out, *replaced})),
    )
    standing = furnished(section, changed).props
    named_props = furniture_mentions(
        texts, LandmarkMap.of(landmarks_by_kind(placed_things(standing), KNOWN)), space.ground
    )
    return replace(changed, added=(*changed.added, *own_furniture(name, named_props, space, standing)))


def _origins(own: OwnFurniture, furniture: OwnFurniture) -> tuple[str, ...]:
    """Return the origin of each prop that an episode adds: first those that its texts name, then the drawn ones."""
    named = [TEXT if prop.kind in DRAWN_KINDS else COLOUR for prop in own.added]
    return (*named, *[DRAWN] * (len(furniture.added) - len(named)))


def _with_distracters(
    name: str,
    mine: OwnFurniture,
    named_props: Mapping[str, Sequence[Prop]],
    texts: Sequence[TurnText],
    section: Section,
    space: FreeSpace,
) -> OwnFurniture:
    landmarks = tuple(prop for prop in mine.added if prop.kind not in DRAWN_KINDS)
    distracters = distracter_furniture(
        name,
        named_props[name],
        frozenset(event.kind for each in texts for event in each.events),
        {other: props for other, props in named_props.items() if other != name},
        space,
        furnished(section, replace(mine, added=landmarks)).props,
    )
    return replace(mine, added=(*mine.added, *distracters))


def _recovered(index: int, landmark: RecoveredLandmark) -> RecoveredLook:
    languages = Counter(dict(landmark.languages))
    return RecoveredLook(index, landmark.votes, dict(sorted(languages.items())))
