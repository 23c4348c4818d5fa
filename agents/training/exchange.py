"""Things exchanged for others, in what is seen and in what is said alike: so that `vl_grounded` learns to find what is
named, and not which things stand where in the few streets that it is trained in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from random import Random

import numpy as np
import numpy.typing as npt

import arramon_lang as lang
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.vocabulary import COLOURED, LOOK_GROUPS
from arramon_client.world import BANNER_COLOURS, COLLECTIBLE_COLOURS, COLLECTIBLES, FURNITURE
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk
from arramon_lang.reference import mentions
from arramon_lang.room import RoomObject

Names = Mapping[str, str]
"""What each name is exchanged for."""

_LOOKS = {group.name: group.looks for group in LOOK_GROUPS}

PLAIN = tuple(kind for kind in FURNITURE if kind not in (*COLOURED, "banner", "shop_sign", "zebra_crossing"))
"""Furniture that is named by its kind alone."""


@dataclass(frozen=True)
class Exchange:
    """What is exchanged for what: collectibles, their colours and patterns, plain furniture, facades, what is on
    banners and signs.

    Attributes:
        names: by group, as in the names of the visual encoder's channels.
    """

    names: Mapping[str, Names]

    @classmethod
    def draw(cls, random: Random) -> "Exchange":
        """Return an exchange by chance."""
        groups: dict[str, Sequence[str]] = {
            "kind": COLLECTIBLES,
            "colour": COLLECTIBLE_COLOURS,
            "furniture": PLAIN,
            "banner colour": BANNER_COLOURS,
            **{name: _LOOKS[name] for name in ("pattern", "shape", "shop", "facade")},
        }
        return cls(
            {name: dict(zip(each, random.sample(each, len(each)), strict=True)) for name, each in groups.items()}
        )

    @cached_property
    def channels(self) -> npt.NDArray[np.int64]:
        """From which channel of the encoder each of the exchanged features comes."""
        source = list(range(len(CHANNEL_NAMES)))
        for group, names in self.names.items():
            for old, new in names.items():
                source[CHANNEL_NAMES.index(f"{group}:{new}")] = CHANNEL_NAMES.index(f"{group}:{old}")
        return np.array(source)

    def meaning(self, meaning: Meaning) -> Meaning:
        """Return what an instruction says, with its things exchanged."""
        if isinstance(meaning, Navigation):
            return Navigation(tuple(map(self._step, meaning.steps)), self.thing(meaning.target))
        return Assembly(
            meaning.turns,
            self.thing(meaning.thing),
            tuple(replace(where, things=tuple(map(self.thing, where.things))) for where in meaning.where),
        )

    def standing(self, things: Sequence[RoomObject]) -> tuple[RoomObject, ...]:
        """Return the things of a room, exchanged."""
        return tuple(
            replace(
                thing,
                kind=self.names["kind"][thing.kind],
                colour=self.names["colour"][thing.colour],
                look=self.names["pattern"][thing.look],
            )
            for thing in things
        )

    def thing(self, thing: Thing) -> Thing:
        """Return what a thing is exchanged for."""
        colours, looks = "", ""
        if thing.kind in COLLECTIBLES or not thing.kind:
            colours, looks = "colour", "pattern"
        elif thing.kind == "banner":
            colours, looks = "banner colour", "shape"
        elif thing.kind == "shop_sign":
            looks = "shop"
        elif thing.kind in ("building", "building_corner"):
            looks = "facade"
        kind = self.names["kind"].get(thing.kind) or self.names["furniture"].get(thing.kind) or thing.kind
        return replace(
            thing,
            kind=kind,
            colour=self.names.get(colours, {}).get(thing.colour, thing.colour),
            look=self.names.get(looks, {}).get(thing.look, thing.look),
            where=tuple(replace(where, things=tuple(map(self.thing, where.things))) for where in thing.where),
        )

    def _step(self, step: Step) -> Step:
        if isinstance(step, Walk):
            return replace(step, things=tuple(map(self.thing, step.things)))
        if isinstance(step, Face):
            return replace(step, thing=self.thing(step.thing))
        assert isinstance(step, Rotate)
        return replace(step, thing=step.thing and self.thing(step.thing))


@dataclass(frozen=True)
class Version:
    """An instruction as it is, or with things exchanged.

    Attributes:
        texts: by language.
        exchange: with which it was written; None as it is.
    """

    texts: Mapping[str, str]
    exchange: Exchange | None = None


def versions(texts: Mapping[str, str], phase: str, languages: Sequence[str], count: int, seed: str) -> list[Version]:
    """Return an instruction, and others that say the same of other things, in every language.

    Args:
        texts: the instruction by language.
        phase: "navigation" or "assembly".
        languages: in which the others are written.
        count: of the others.
        seed: of all choices.
    """
    found = [Version(texts)]
    if count:
        meaning, random = read_meaning(texts, phase), Random(seed)  # noqa: S311 - not for secrets
        for _ in range(count):
            exchange = Exchange.draw(random)
            other = exchange.meaning(meaning)
            found.append(Version({each: lang.load(each).write(other, random) for each in languages}, exchange))
    return found


def read_meaning(texts: Mapping[str, str], phase: str) -> Meaning:
    """Return what an instruction says, read by the grammar, from the language that tells most about junctions.

    All languages say the same; some tell besides how many streets meet at a junction.

    Args:
        texts: the instruction by language.
        phase: "navigation" or "assembly".

    Raises:
        ValueError: the text in the first language cannot be read.
    """
    (language, text), *others = texts.items()
    first = lang.load(language).read(text, phase)
    alike = [meaning for meaning in (_read(*other, phase) for other in others) if meaning == first]
    return max([first, *alike], key=lambda meaning: sum(thing.arms > 0 for thing in mentions(meaning)))


def _read(language: str, text: str, phase: str) -> Meaning | None:
    """Return what a text says, or None if it cannot be read."""
    try:
        return lang.load(language).read(text, phase)
    except ValueError:
        return None
