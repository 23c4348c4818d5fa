"""Recovered landmarks in the colour that an episode's own text states.

People differ in the name of a colour: some call the same barrel gold, some orange, some yellow.
"""

from collections.abc import Sequence
from dataclasses import replace

from arramon_dataset.release.landmarks.agreement import (
    WITHIN,
    landmarks_by_kind,
    mentions_of,
    nearest_match,
    placed_things,
)
from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.mentions import SCENERY
from arramon_dataset.release.landmarks.recovery import LandmarkMap, RecoveredLandmark, TurnText
from arramon_dataset.release.landmarks.scenery import look_of
from arramon_server.sim.section import Prop


def recolour_landmarks(
    texts: Sequence[TurnText], standing: Sequence[Prop], landmarks: Sequence[RecoveredLandmark], strength: float
) -> dict[int, Prop]:
    """Return the landmarks whose colour an episode's texts state differently from most texts, in that colour.

    Only colours that other texts give the landmark too are used; a banner also gets the shape that the text states.

    Args:
        texts: those of the episode.
        standing: the scenery as it is in the episode.
        landmarks: from which it was made, in the same order.
        strength: of each thing in the alignment of the texts.

    Returns:
        Props by their index in `standing`.
    """
    changed: dict[int, Prop] = {}
    things = placed_things(standing)
    known = LandmarkMap.of(landmarks_by_kind(things, strength))
    for each in texts:
        if not each.events:
            continue
        aligned = align(each.events, each.path, known.fit)
        for event, place, thing in mentions_of(each.events, aligned, each.path, things, SCENERY):
            if thing >= 0 or not event.colour:
                continue
            same = [number for number, landmark in enumerate(landmarks) if event.colour in landmark.names]
            plain = replace(event, colour="", look="")
            number, apart = nearest_match(plain, place, each.path, [things[number] for number in same])
            if apart <= WITHIN:
                at = same[number]
                landmark = landmarks[at]
                colour, shape, drawn = look_of(replace(landmark, colour=event.colour, look=event.look or landmark.look))
                changed.setdefault(at, replace(standing[at], colour=colour, shape=shape, shape_colour=drawn))
    return changed
