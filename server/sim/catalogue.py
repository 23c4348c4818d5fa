"""The collectible objects: 7 kinds x 2 patterns x 7 colours (the paper's figures 2 and 11)."""

from dataclasses import dataclass
from itertools import product

from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLE_PATTERNS, COLLECTIBLES

EXTENT = 0.15
"""Radius of a collectible's footprint in the city, in units; the pick-up box is tested against the object's extent."""


@dataclass(frozen=True, slots=True, order=True)
class ObjectType:
    """Appearance of an object, for example a dotted yellow hourglass.

    Raises:
        ValueError: for a pattern, colour or kind that is not in the catalogue.
    """

    pattern: str
    colour: str
    kind: str

    def __post_init__(self) -> None:
        known_words = (
            (self.pattern, COLLECTIBLE_PATTERNS),
            (self.colour, COLLECTIBLE_COLOURS),
            (self.kind, COLLECTIBLES),
        )
        for word, known in known_words:
            if word not in known:
                raise ValueError(f"{word!r} is not one of {', '.join(known)}")

    @classmethod
    def parse(cls, name: str) -> "ObjectType":
        """Return the type with a name such as "Dotted Yellow Hourglass".

        Raises:
            ValueError: unless the name is a pattern, a colour and a kind.
        """
        words = name.lower().split()
        if len(words) != 3:
            raise ValueError(f"{name!r} is not a pattern, a colour and a kind, such as 'Dotted Yellow Hourglass'")
        return cls(*words)

    def __str__(self) -> str:
        return f"{self.pattern} {self.colour} {self.kind}"


ALL_TYPES = tuple(ObjectType(*words) for words in product(COLLECTIBLE_PATTERNS, COLLECTIBLE_COLOURS, COLLECTIBLES))
"""All 98 types."""
