"""Data augmentation: permute the names of things, consistently in instructions and visual features.

Without it, agents memorise where things are in the few training sections instead of finding what is named.
"""

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
from arramon_lang.cell_grading import RoomObject
from arramon_lang.coreference import mentions
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk

Names = Mapping[str, str]
"""New name by old name."""

_LOOKS = {group.name: group.looks for group in LOOK_GROUPS}

PLAIN_FURNITURE = tuple(kind for kind in FURNITURE if kind not in (*COLOURED, "banner", "shop_sign", "zebra_crossing"))
"""Kinds of furniture without colour or look."""


@dataclass(frozen=True)
class NamePermutation:
    """Permutation of the names of things: collectibles with colours and patterns, furniture, facades, banners, signs.

    Attributes:
        names: new name by old name, for each group of the visual encoder's channel names.
    """

    names: Mapping[str, Names]

    @classmethod
    def draw(cls, random: Random) -> "NamePermutation":
        """Draw a random permutation."""
        groups: dict[str, Sequence[str]] = {
            "kind": COLLECTIBLES,
            "colour": COLLECTIBLE_COLOURS,
            "furniture": PLAIN_FURNITURE,
            "banner colour": BANNER_COLOURS,
            **{name: _LOOKS[name] for name in ("pattern", "shape", "shop", "facade")},
        }
        return cls(
            {name: dict(zip(each, random.sample(each, len(each)), strict=True)) for name, each in groups.items()}
        )

    @cached_property
    def channels(self) -> npt.NDArray[np.int64]:
        """Source channel of each channel of the permuted visual features."""
        source = list(range(len(CHANNEL_NAMES)))
        for group, names in self.names.items():
            for old, new in names.items():
                source[CHANNEL_NAMES.index(f"{group}:{new}")] = CHANNEL_NAMES.index(f"{group}:{old}")
        return np.array(source)

    def permute_meaning(self, meaning: Meaning) -> Meaning:
        """Return the meaning of an instruction with its names permuted."""
        if isinstance(meaning, Navigation):
            return Navigation(tuple(map(self._step, meaning.steps)), self.thing(meaning.target))
        return Assembly(
            meaning.turns,
            self.thing(meaning.thing),
            tuple(replace(where, things=tuple(map(self.thing, where.things))) for where in meaning.where),
        )

    def permute_objects(self, things: Sequence[RoomObject]) -> tuple[RoomObject, ...]:
        """Return the objects of a room with their names permuted."""
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
        """Return a thing with its new names."""
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
class InstructionVersion:
    """An instruction, original or with its names permuted.

    Attributes:
        texts: instruction by language.
        permutation: the permutation of names; None for the original.
    """

    texts: Mapping[str, str]
    permutation: NamePermutation | None = None


def instruction_versions(
    texts: Mapping[str, str], phase: str, languages: Sequence[str], count: int, seed: str
) -> list[InstructionVersion]:
    """Return an instruction and augmented versions of it, with names permuted, in every language.

    Args:
        texts: the instruction by language.
        phase: "navigation" or "assembly".
        languages: languages of the augmented versions.
        count: number of augmented versions.
        seed: seed of all random choices.
    """
    found = [InstructionVersion(texts)]
    if count:
        meaning, random = read_meaning(texts, phase), Random(seed)  # noqa: S311 - not for secrets
        for _ in range(count):
            permutation = NamePermutation.draw(random)
            other = permutation.permute_meaning(meaning)
            found.append(
                InstructionVersion({each: lang.load(each).write(other, random) for each in languages}, permutation)
            )
    return found


def read_meaning(texts: Mapping[str, str], phase: str) -> Meaning:
    """Return the meaning of an instruction, parsed by the grammar of the language that is most specific.

    All languages have the same meaning, but only some name the number of streets at a junction.

    Args:
        texts: the instruction by language.
        phase: "navigation" or "assembly".

    Raises:
        ValueError: if the text in the first language cannot be parsed.
    """
    (language, text), *others = texts.items()
    first = lang.load(language).read(text, phase)
    alike = [meaning for meaning in (_read(*other, phase) for other in others) if meaning == first]
    return max([first, *alike], key=lambda meaning: sum(thing.arms > 0 for thing in mentions(meaning)))


def _read(language: str, text: str, phase: str) -> Meaning | None:
    """Return the meaning of a text; None if it cannot be parsed."""
    try:
        return lang.load(language).read(text, phase)
    except ValueError:
        return None
