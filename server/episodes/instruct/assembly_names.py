"""How an assembly's plan names things: as short as stays unique, sometimes in full, sometimes by what stands near."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from random import Random

from lang.meaning import Thing, Where
from lang.placing import Room, Standing, relative, weigh_things
from server.sim.catalogue import ObjectType

IN_FULL, WITH_PLACE = 0.55, 0.1
"""How often a landmark is named by all its words though fewer would do, and with where it stands."""

TARGET_NAMES = (
    (("look", "colour", "kind"), 64),
    (("kind",), 22),
    (("colour", "kind"), 6),
    (("look", "kind"), 4),
    ((), 4),
)
"""Which words name the object in hand, and how often; none for a pronoun. The release: all words 69%, the kind alone
27%, no kind 4%."""

SHORT = tuple(
    words for size in (1, 2, 3) for words in combinations(("kind", "colour", "look"), size) if "kind" in words
)
"""The words that may name a landmark, the fewest first."""

CLEARLY = 1.5
"""How much likelier than any other thing the one named must be."""


@dataclass(frozen=True, slots=True)
class Names:
    """What names are drawn in view of.

    Attributes:
        seen: what the agent sees: what is mentioned.
        whole: what there is: what must not be confused with it.
        target: the object in hand, which a name should not mean either.
        quarter: where the agent looks, clockwise from +row.
    """

    seen: Room
    whole: Room
    target: ObjectType
    quarter: int

    def of_target(self, random: Random) -> Thing:
        """The object in hand."""
        words = random.choices([words for words, _ in TARGET_NAMES], [share for _, share in TARGET_NAMES])[0]
        return _named(self.target.kind, self.target.colour, self.target.pattern, words)

    def of(self, item: Standing, random: Random) -> Thing | None:
        """A name that means this one alone; None where there is none."""
        if random.random() < WITH_PLACE:
            placed = self._placed(item, random)
            if placed is not None:
                return placed
        names = [_named(item.kind, item.colour, item.look, words) for words in SHORT]
        unique = [name for name in names if self._is_unique(name, item)]
        if not unique:
            return self._placed(item, random)
        if random.random() < IN_FULL:
            return unique[-1]
        fewest = _length(unique[0])
        return random.choice([name for name in unique if _length(name) == fewest])

    def _is_unique(self, name: Thing, item: Standing) -> bool:
        others = [(o.kind, o.colour, o.look) for o in self.whole.things if o != item]
        target = (self.target.kind, self.target.colour, self.target.pattern)
        if target != (item.kind, item.colour, item.look):  # else nothing but "the other one" sets them apart
            others.append(target)
        return not any(_means(name, *other) for other in others)

    def _placed(self, item: Standing, random: Random) -> Thing | None:
        """A name with where it stands, such as "the mug in front of the bowl"; None where nothing stands by."""
        places = list(self._places(item))
        random.shuffle(places)
        for where in places:
            for words in random.sample(SHORT, len(SHORT)):
                name = _named(item.kind, item.colour, item.look, words, (where,))
                if self._is_clear(name, item):
                    return name
        return None

    def _places(self, item: Standing) -> Iterable[Where]:
        for other in self.seen.things:
            name = _named(other.kind, other.colour, other.look, SHORT[-1])
            relation = "on_top_of" if _is_on(item, other) else beside(item, other, self.quarter)
            if other != item and relation and self._is_unique(name, other):
                yield Where(relation, (name,))

    def _is_clear(self, name: Thing, item: Standing) -> bool:
        for room in (self.seen, self.whole):
            weights = weigh_things(name, room, self.quarter, is_told=False)
            chances = {landmark: weight for weight, landmark in weights}
            rest = max((weight for landmark, weight in chances.items() if landmark != item), default=0.0)
            if chances.get(item, 0.0) < 0.9 or rest * CLEARLY > chances[item]:
                return False
        return True


def beside(item: Standing, other: Standing, quarter: int) -> str:
    """How an item stands to one in the next cell, both on the floor, seen in a quarter; "" if it does not."""
    if item.level != 1 or other.level != 1:
        return ""
    sides = {(-1, 0): "left_of", (1, 0): "right_of", (0, -1): "in_front_of", (0, 1): "behind"}
    return sides.get(relative(item.cell, other.cell, quarter), "")


def _is_on(item: Standing, other: Standing) -> bool:
    return item.cell == other.cell and item.level == other.level + 1


def _named(kind: str, colour: str, look: str, words: tuple[str, ...], where: tuple[Where, ...] = ()) -> Thing:
    said = {word: text for word, text in (("kind", kind), ("colour", colour), ("look", look)) if word in words}
    return Thing(said.get("kind", ""), said.get("colour", ""), said.get("look", ""), where=where)


def _means(name: Thing, kind: str, colour: str, look: str) -> bool:
    return name.kind in ("", kind) and name.colour in ("", colour) and name.look in ("", look)


def _length(name: Thing) -> int:
    return sum(map(bool, (name.kind, name.colour, name.look)))
