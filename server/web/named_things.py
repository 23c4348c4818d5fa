"""Names of things on maps (collectibles, street furniture, buildings), and detection of those that a text mentions."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from arramon_client.world import COLLECTIBLES
from arramon_server.scoring.trajectory import Point2
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.section import Prop, Section
from arramon_server.web.page_texts import PageTexts

NEAR = 9.0
"""Maximum distance from the ground-truth path at which a thing counts as mentioned by the instruction, in units."""

MAX_PER_NAME = 3
"""Maximum number of labelled things with the same name: those nearest to the ground-truth path."""


@dataclass(frozen=True, slots=True)
class NamedThing:
    """A thing that a text mentions.

    Attributes:
        name: its name in the page's language.
        position: (x, z) on the ground, in units.
    """

    name: str
    position: Point2


def object_name(t: PageTexts, type_: ObjectType) -> str:
    """Return the name of a collectible."""
    kind = t(f"objects.{type_.kind}")
    colour = _agreeing(t, f"objects.{type_.colour}", kind)
    return t("objects.phrase", pattern=t(f"objects.{type_.pattern}"), colour=colour, kind=kind)


def first_name(t: PageTexts, kind: str, look: str = "") -> str:
    """Return the name of a kind of things; empty if people have none for it.

    Args:
        t: texts in the language of the name.
        kind: a collectible's kind, or the kind of a segmentation label.
        look: look of a building or of a wall; ignored for other kinds.
    """
    if kind in COLLECTIBLES:
        return t(f"objects.{kind}")
    if kind == "wall":
        return t(f"objects.wall_{look}")
    key = f"things.building_{look}" if kind == "building" else f"things.{kind}"
    return _first(t, key) if key in t.words else ""


def thing_name(t: PageTexts, label: SegmentationLabel) -> str:
    """Return the name of a thing with a segmentation label; empty if people have none for it."""
    if label.kind in COLLECTIBLES:
        return object_name(t, ObjectType(label.look, label.colour, label.kind))
    name = first_name(t, label.kind, label.look)
    if name and label.colour:
        name = t("objects.coloured", colour=_agreeing(t, f"colours.{label.colour}", name), kind=name)
    if name and label.look and label.kind not in ("building", "wall"):
        name = t("objects.with_look", kind=name, look=t(f"objects.look_{label.look}"))
    return name


def named_things(
    t: PageTexts, instruction_words: PageTexts, section: Section, text: str, path: Sequence[Point2]
) -> list[NamedThing]:
    """Return furniture and buildings near a path whose kind a text mentions.

    If a text says "the bench" and the street has several, those nearest to the path are returned. This only helps
    readers of the map: it looks up the words in `texts/LANGUAGE.toml`, and does not parse the text.

    Args:
        t: texts in the page's language, for the names.
        instruction_words: texts in the instruction's language.
        section: the section, with the episode's own furniture.
        text: a navigation instruction.
        path: positions on the ground-truth path.
    """
    lower = text.casefold()
    found: dict[str, list[tuple[float, NamedThing]]] = {}
    for prop in section.props:
        key = f"things.{prop.kind}"
        if _mentions(instruction_words, key, lower) and (colour := _colour(instruction_words, prop, lower)) is not None:
            name = _first(t, key)
            if colour:
                name = t("objects.coloured", colour=_agreeing(t, colour, name), kind=name)
            _add(found, name, (prop.x, prop.z), path, 0.0)
    for building in section.buildings:
        key = f"things.building_{building.facade}"
        if _mentions(instruction_words, key, lower):
            _add(found, _first(t, key), (building.x, building.z), path, max(building.half_width, building.half_length))
    return [one for name in found for _, one in sorted(found[name], key=lambda pair: pair[0])[:MAX_PER_NAME]]


def _add(
    found: dict[str, list[tuple[float, NamedThing]]], name: str, place: Point2, path: Sequence[Point2], extent: float
) -> None:
    distance = min(math.dist(place, point) for point in path)
    if distance - extent <= NEAR:
        found.setdefault(name, []).append((distance, NamedThing(name, place)))


def _mentions(instruction_words: PageTexts, key: str, text: str) -> bool:
    return _pattern(instruction_words(key)).search(text) is not None


def _first(t: PageTexts, key: str) -> str:
    """Return the first of the alternative words that the text of a key lists."""
    return t(key).partition("|")[0]


def _agreeing(t: PageTexts, key: str, noun: str) -> str:
    """Return an adjective in the form that agrees with a noun: the third of three forms if the noun is feminine."""
    forms = t(key).split("|")
    return forms[2] if len(forms) == 3 and noun in t("objects.feminine").split("|") else forms[0]


def _colour(instruction_words: PageTexts, prop: Prop, text: str) -> str | None:
    """Return the key of a prop's colour if the text names it with the kind; empty if it names none; else None."""
    keys = [key for key in instruction_words.words if key.startswith("colours.")]
    mentioned = {
        key for key in keys if _pair(instruction_words(key), instruction_words(f"things.{prop.kind}")).search(text)
    }
    if not mentioned or not prop.colour:
        return ""
    return f"colours.{prop.colour}" if f"colours.{prop.colour}" in mentioned else None


@lru_cache(512)
def _pattern(words: str) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w)(?:{_any_of(words)})(?!\w)")


@lru_cache(2048)
def _pair(before: str, after: str) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w)(?:{_any_of(before)})\s+(?:{_any_of(after)})(?!\w)")


def _any_of(words: str) -> str:
    return "|".join(re.escape(word.casefold()) for word in sorted(words.split("|"), key=len, reverse=True))
