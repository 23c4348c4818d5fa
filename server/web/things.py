"""Words for things on maps: collectibles, street furniture and buildings, and which of them a text names."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from arramon_server.scoring.trajectory import Point2
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.section import Prop, Section
from arramon_server.web.texts import Texts

NEAR = 9.0
"""Greatest distance from the ground truth of a thing that its instruction is taken to name, in units."""

MOST = 3
"""Things of one name that are labelled: the nearest to the ground truth."""


@dataclass(frozen=True, slots=True)
class Named:
    """A thing that a text names.

    Attributes:
        name: the word for it.
        position: (x, z) on the ground, in units.
    """

    name: str
    position: Point2


def object_name(t: Texts, type_: ObjectType) -> str:
    """Return the words for a collectible."""
    words = {name: t(f"objects.{getattr(type_, name)}") for name in ("pattern", "colour", "kind")}
    return t("objects.phrase", **words)


def named_things(t: Texts, spoken: Texts, section: Section, text: str, path: Sequence[Point2]) -> list[Named]:
    """Return the furniture and the buildings near a path whose kind a text names.

    A text says "the bench", and its street may have several: those that are nearest to the path are returned. It is a
    help for readers, not a reading: the words of `texts/LANGUAGE.toml` are looked for, and no grammar.

    Args:
        t: words of the page's language, for the names.
        spoken: words of the text's language.
        section: with the episode's own furniture.
        text: a navigation instruction.
        path: positions of the ground truth.
    """
    lower = text.casefold()
    found: dict[str, list[tuple[float, Named]]] = {}
    for prop in section.props:
        key = f"things.{prop.kind}"
        if _says(spoken, key, lower) and (colour := _colour(spoken, prop, lower)) is not None:
            name = _first(t, key)
            if colour:
                name = t("objects.coloured", colour=_first(t, colour), kind=name)
            _add(found, name, (prop.x, prop.z), path, 0.0)
    for building in section.buildings:
        key = f"things.building_{building.facade}"
        if _says(spoken, key, lower):
            _add(found, _first(t, key), (building.x, building.z), path, max(building.half_width, building.half_length))
    return [one for name in found for _, one in sorted(found[name], key=lambda pair: pair[0])[:MOST]]


def _add(
    found: dict[str, list[tuple[float, Named]]], name: str, place: Point2, path: Sequence[Point2], extent: float
) -> None:
    distance = min(math.dist(place, point) for point in path)
    if distance - extent <= NEAR:
        found.setdefault(name, []).append((distance, Named(name, place)))


def _says(spoken: Texts, key: str, text: str) -> bool:
    return _pattern(spoken(key)).search(text) is not None


def _first(t: Texts, key: str) -> str:
    """Return the word that is shown for a key whose text lists all words for it."""
    return t(key).partition("|")[0]


def _colour(spoken: Texts, prop: Prop, text: str) -> str | None:
    """Return the key of a prop's colour if the text says it of the kind; empty if it says none; None if another one."""
    keys = [key for key in spoken.words if key.startswith("colours.")]
    said = {key for key in keys if _pair(spoken(key), spoken(f"things.{prop.kind}")).search(text)}
    if not said or not prop.colour:
        return ""
    return f"colours.{prop.colour}" if f"colours.{prop.colour}" in said else None


@lru_cache(512)
def _pattern(words: str) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w)(?:{_any_of(words)})(?!\w)")


@lru_cache(2048)
def _pair(before: str, after: str) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w)(?:{_any_of(before)})\s+(?:{_any_of(after)})(?!\w)")


def _any_of(words: str) -> str:
    return "|".join(re.escape(word.casefold()) for word in sorted(words.split("|"), key=len, reverse=True))
