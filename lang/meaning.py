"""Language-independent meanings of instructions: planners produce them, languages express them, readers recover them.

Strings here are the project's own identifiers, never words of a language; each language's data maps its words to them.
"""

from dataclasses import dataclass, field

TURNS = ("left", "right", "around", "slightly left", "slightly right")
"""Directions of turns: about 90, 90, 180, 30 and 30 degrees."""

WAYS = ("ahead", "to", "towards", "until", "beside", "past", "between", "along")
"""Kinds of walks. "ahead": straight on until the next step applies (or for `Walk.count` steps). "to": until the thing
is reached. "towards": in its direction, until the next step applies. "until": straight on until it is seen. "beside":
until it is on the stated side. "past": until it is behind. "between": through the
gap of two things. "along": keeping beside it."""

ATS = ("at", "before", "after")
"""Where a turn is made relative to a thing on the way: at it, before reaching it, after passing it."""

RELATIONS = ("on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near", "against", "diagonal_to")
"""Relations of one thing to another: those of the languages' `relations.toml`, and "diagonal_to"."""

OTHER_SIDE = {
    "left": "right", "right": "left", "slightly left": "slightly right", "slightly right": "slightly left",
    "left_of": "right_of", "right_of": "left_of",
}  # fmt: skip
"""What directions, sides and relations become in a mirror image; others stay."""

PLACES = ("intersection", "t_junction", "corner", "building_corner", "street", "alley", "square", "street_end")
"""Kinds of things that are not solid: a crossing of streets, a place where a street ends at another, a corner where a
street opens, the same with the look of the building there, a street, a narrow one, an open square, a street's end."""

WHICHES = ("", "first", "second", "third", "last", "nearest", "next", "another")
"""Which of several things that fit a name is meant: an ordinal along the way, "nearest", "next" (the first one farther
on that has not been mentioned) or "another" (one that has not been mentioned)."""

NUMBERS = ("", "two", "several")
"""How many things are named together: one, both of two ("both benches"), or several ("the cones")."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A visible thing, described as far as the instruction describes it.

    Attributes:
        kind: a collectible's ("mug"), street furniture's ("phone_booth", "banner"), "building", "wall", one of PLACES,
            "" if only attributes are stated ("the dotted one"), or "you", the agent itself ("in front of you").
        colour: "red", ...; "" if not stated.
        look: a collectible's pattern ("dotted"), a banner's shape ("star"), a building's facade ("brick"), a wall's
            look ("spotted"); "" if not stated.
        which: one of WHICHES, counted along the way.
        where: stated relations to other things ("the bucket in front of the TV").
        number: one of NUMBERS.
        identity: names the object or place itself, the same for all mentions of one thing in an instruction; "" if
            unknown. Excluded from comparison: a reader recovers which mentions are of one thing, not these names.
        arms: number of streets that meet at a junction, by which some languages name it; 0 if unknown. Excluded from
            comparison as well.
    """

    kind: str
    colour: str = ""
    look: str = ""
    which: str = ""
    where: tuple["Where", ...] = ()
    number: str = ""
    identity: str = field(default="", compare=False)
    arms: int = field(default=0, compare=False)

    def __post_init__(self) -> None:
        _check("which", self.which, WHICHES)
        _check("number", self.number, NUMBERS)

    def is_same(self, other: "Thing | None") -> bool:
        """Return whether both are known to be one thing, however they are named."""
        return other is not None and bool(self.identity) and self.identity == other.identity


@dataclass(frozen=True, slots=True)
class Where:
    """A relation to one thing, or to two ("between").

    Attributes:
        relation: one of RELATIONS.
        things: the landmarks.
        exactly: whether it is stated to be direct ("directly behind").
    """

    relation: str
    things: tuple[Thing, ...]
    exactly: bool = False

    def __post_init__(self) -> None:
        _check("relation", self.relation, RELATIONS)
        if len(self.things) != (2 if self.relation == "between" else 1):
            raise ValueError(f"{self.relation} of {len(self.things)} things; expected 2 for between, otherwise 1")


@dataclass(frozen=True, slots=True)
class Rotate:
    """A turn, on the spot or at a thing farther on.

    Attributes:
        direction: one of TURNS.
        at: one of ATS, with `thing`; "" to turn on the spot.
        thing: a landmark or one of PLACES.
    """

    direction: str
    at: str = ""
    thing: Thing | None = None

    def __post_init__(self) -> None:
        _check("direction", self.direction, TURNS)
        _check("at", self.at, ("", *ATS))
        if bool(self.at) != (self.thing is not None):
            raise ValueError("a turn has both `at` and `thing`, or neither")


@dataclass(frozen=True, slots=True)
class Face:
    """A turn until the thing is straight ahead."""

    thing: Thing


@dataclass(frozen=True, slots=True)
class Walk:
    """A walk in the current direction or relative to things.

    Attributes:
        way: one of WAYS.
        things: what the walk refers to: none with "ahead", two with "between", otherwise one.
        side: "left" or "right" if the thing's side is stated ("past the bench on your left"), else "".
        count: number of steps if stated ("about five steps"), else 0.
        straight: whether the things are straight ahead, so that "straight to the bench" may be said. Excluded from
            comparison: a reader cannot know it of a text that does not say so.
    """

    way: str
    things: tuple[Thing, ...] = ()
    side: str = ""
    count: int = 0
    straight: bool = field(default=True, compare=False)

    def __post_init__(self) -> None:
        _check("way", self.way, WAYS)
        _check("side", self.side, ("", "left", "right"))
        if self.way == "beside" and not self.side:
            raise ValueError("beside without a side")
        if len(self.things) != {"ahead": 0, "between": 2}.get(self.way, 1):
            raise ValueError(f"{self.way} with {len(self.things)} things")


Step = Rotate | Face | Walk


@dataclass(frozen=True, slots=True)
class Navigation:
    """A navigation instruction: steps in order, then the object to pick up.

    Attributes:
        target: the object to pick up; `target.where` holds its relations to landmarks.
    """

    steps: tuple[Step, ...]
    target: Thing


@dataclass(frozen=True, slots=True)
class Assembly:
    """An assembly instruction: turns, the object to place, and the relations of its cell.

    Relations are as seen by the agent on its tile after these turns: left and right are its own, "in front of" is on
    its side of the thing, "behind" on the far side.

    Attributes:
        turns: of TURNS, in order; usually none or one.
        thing: the object to place, as far as it is named; kind "" for a pronoun.
        where: relations that all hold for the cell.
    """

    turns: tuple[str, ...]
    thing: Thing
    where: tuple[Where, ...]

    def __post_init__(self) -> None:
        for turn in self.turns:
            _check("turn", turn, TURNS)


Meaning = Navigation | Assembly


def _check(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"{name} {value!r} is not one of {', '.join(map(repr, known))}")
