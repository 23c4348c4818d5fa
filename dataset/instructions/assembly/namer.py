"""Unique names for objects in assembly instructions: short, complete, or with a relation to a neighbour."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations
from random import Random

from arramon_lang.cell_grading import Room, RoomObject, relative, weigh_things
from arramon_lang.meaning import Thing, Where
from arramon_server.sim.catalogue import ObjectType

IN_FULL, WITH_PLACE = 0.9, 0.05
"""Probabilities of a landmark's complete name although fewer words suffice, and of a name with a relation."""

TARGET_NAMES = (
    (("look", "colour", "kind"), 70),
    (("kind",), 26),
    (("colour", "kind"), 3),
    (("look", "kind"), 0.5),
    ((), 0.5),
)
"""Attributes in the name of the object in hand, with weights; () for a pronoun. In the release: all attributes 69%, the
kind alone 27%, no kind 4%."""

SHORT = tuple(
    words for size in (1, 2, 3) for words in combinations(("kind", "colour", "look"), size) if "kind" in words
)
"""Combinations of attributes that may name a landmark, the shortest first."""

HELD = "held"
"""Identity of the object in the agent's hand."""

MIN_LIKELIHOOD_RATIO = 1.5
"""Minimum ratio of the named object's likelihood and any other's."""


@dataclass(frozen=True, slots=True)
class ObjectNamer:
    """Names the objects in a room.

    Attributes:
        seen: the part of the room visible to the agent; only its objects are mentioned.
        whole: the whole room; names must be unique in it.
        target: type of the object in hand; landmark names must not match it either.
        quarter: viewing direction of the agent in quarter turns clockwise from +row.
    """

    seen: Room
    whole: Room
    target: ObjectType
    quarter: int

    def name_target(self, random: Random) -> Thing:
        """Return a random name for the object in hand."""
        words = random.choices([words for words, _ in TARGET_NAMES], [share for _, share in TARGET_NAMES])[0]
        held = RoomObject(self.target.kind, self.target.colour, self.target.pattern, -1, -1)
        return replace(_named(held, words), identity=HELD)

    def name(self, item: RoomObject, random: Random) -> Thing | None:
        """Return a name that matches this item alone, or None if there is none."""
        if random.random() < WITH_PLACE:
            placed = self._placed(item, random)
            if placed is not None:
                return placed
        names = [_named(item, words) for words in SHORT]
        unique = [name for name in names if self._is_unique(name, item)]
        if not unique:
            return self._placed(item, random)
        if random.random() < IN_FULL:
            return unique[-1]
        fewest = _length(unique[0])
        return random.choice([name for name in unique if _length(name) == fewest])

    def _is_unique(self, name: Thing, item: RoomObject) -> bool:
        others = [(o.kind, o.colour, o.look) for o in self.whole.things if o != item]
        target = (self.target.kind, self.target.colour, self.target.pattern)
        if target != (item.kind, item.colour, item.look):  # Otherwise only "the other one" would distinguish them.
            others.append(target)
        return not any(_means(name, *other) for other in others)

    def _placed(self, item: RoomObject, random: Random) -> Thing | None:
        """Return a unique name with a relation to a neighbour, "the mug in front of the bowl", or None."""
        places = list(self._places(item))
        random.shuffle(places)
        for where in places:
            for words in random.sample(SHORT, len(SHORT)):
                name = _named(item, words, (where,))
                if self._is_clear(name, item):
                    return name
        return None

    def _places(self, item: RoomObject) -> Iterable[Where]:
        for other in self.seen.things:
            name = _named(other, SHORT[-1])
            relation = "on_top_of" if _is_on(item, other) else adjacent_relation(item, other, self.quarter)
            if other != item and relation and self._is_unique(name, other):
                yield Where(relation, (name,))

    def _is_clear(self, name: Thing, item: RoomObject) -> bool:
        for room in (self.seen, self.whole):
            weights = weigh_things(name, room, self.quarter, is_facing_stated=False)
            chances = {landmark: weight for weight, landmark in weights}
            rest = max((weight for landmark, weight in chances.items() if landmark != item), default=0.0)
            if chances.get(item, 0.0) < 0.9 or rest * MIN_LIKELIHOOD_RATIO > chances[item]:
                return False
        return True


def adjacent_relation(item: RoomObject, other: RoomObject, quarter: int) -> str:
    """Return an item's relation to one in an adjacent cell, both on the floor; "" if none holds.

    Args:
        item, other: the objects.
        quarter: viewing direction of the agent in quarter turns clockwise from +row.
    """
    if item.level != 1 or other.level != 1:
        return ""
    sides = {(-1, 0): "left_of", (1, 0): "right_of", (0, -1): "in_front_of", (0, 1): "behind"}
    return sides.get(relative(item.cell, other.cell, quarter), "")


def _is_on(item: RoomObject, other: RoomObject) -> bool:
    return item.cell == other.cell and item.level == other.level + 1


def _named(item: RoomObject, words: tuple[str, ...], where: tuple[Where, ...] = ()) -> Thing:
    kind, colour, look = (getattr(item, word) if word in words else "" for word in ("kind", "colour", "look"))
    return Thing(kind, colour, look, where=where, identity=object_identity(item))


def object_identity(item: RoomObject) -> str:
    """Return the identity of an object in the room: its place."""
    return f"room/{item.column},{item.level},{item.row}"


def _means(name: Thing, kind: str, colour: str, look: str) -> bool:
    return name.kind in ("", kind) and name.colour in ("", colour) and name.look in ("", look)


def _length(name: Thing) -> int:
    return sum(map(bool, (name.kind, name.colour, name.look)))
