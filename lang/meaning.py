"""Language-independent meanings of instructions, which planners produce, writers express and parsers recover.

Strings are the project's own identifiers, never words of a language; each language's data maps its words to them.
"""

from dataclasses import dataclass, field

TURNS = ("left", "right", "around", "slightly left", "slightly right")
"""Directions of turns: about 90, 90, 180, 30 and 30 degrees."""

WAYS = ("ahead", "to", "towards", "until", "beside", "past", "between", "along")
"""Kinds of walks. "ahead": straight on until the next step applies, or for `Walk.count` steps. "to": until the thing is
reached. "towards": in its direction, until the next step applies. "until": straight on until it is visible. "beside":
until it is on the stated side. "past": until it is behind the walker. "between": through the gap between two things.
"along": following it."""

TURN_POSITIONS = ("at", "before", "after")
"""Positions of a turn relative to a thing on the way: at it, before reaching it, after passing it."""

RELATIONS = ("on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near", "against", "diagonal_to")
"""Spatial relations of one thing to another: those of `relations.toml`, and "diagonal_to"."""

OTHER_SIDE = {
    "left": "right", "right": "left", "slightly left": "slightly right", "slightly right": "slightly left",
    "left_of": "right_of", "right_of": "left_of",
}  # fmt: skip
"""Directions, sides and relations that a mirror image exchanges."""

PLACES = ("intersection", "t_junction", "corner", "building_corner", "street", "alley", "square", "street_end")
"""Kinds of places rather than objects: an intersection, a T-junction, a street corner, a corner identified by the look
of its building, a street, a narrow street, an open square, the end of a street."""

WHICHES = ("", "first", "second", "third", "last", "nearest", "next", "another")
"""Which one of several things that fit a description is meant: an ordinal along the way, "nearest", "next" (the first
one farther on that has not been mentioned) or "another" (any that has not been mentioned)."""

NUMBERS = ("", "two", "several")
"""Number of things that one description covers: one, two ("both benches"), or several ("the cones")."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A visible thing, with the attributes that the instruction states.

    Attributes:
        kind: a collectible's ("mug"), street furniture's ("phone_booth", "banner"), "building", "wall", one of PLACES,
            "" if only attributes are stated ("the dotted one"), or "you", the agent itself ("in front of you").
        colour: "red", ...; "" if not stated.
        look: a collectible's pattern ("dotted"), a banner's shape ("star"), a building's facade ("brick"), a wall's
            look ("spotted"); "" if not stated.
        which: one of WHICHES, counted along the way.
        where: stated relations to other things ("the bucket in front of the TV").
        number: one of NUMBERS.
        identity: identifier of the object or place, shared by all mentions of it in an instruction; "" if unknown.
            Excluded from comparison, as a parser recovers co-reference but not identifiers.
        arms: number of streets that meet at a junction, on which its noun depends in some languages; 0 if unknown.
            Excluded from comparison.
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
        """Return whether both are known to be the same thing, whatever their descriptions."""
        return other is not None and bool(self.identity) and self.identity == other.identity


@dataclass(frozen=True, slots=True)
class Where:
    """A relation to one thing, or to two ("between").

    Attributes:
        relation: one of RELATIONS.
        things: the landmarks.
        exactly: whether the text calls it direct ("directly behind").
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
    """A turn, on the spot or at a thing on the way.

    Attributes:
        direction: one of TURNS.
        at: one of TURN_POSITIONS, with `thing`; "" to turn on the spot.
        thing: a landmark or one of PLACES.
    """

    direction: str
    at: str = ""
    thing: Thing | None = None

    def __post_init__(self) -> None:
        _check("direction", self.direction, TURNS)
        _check("at", self.at, ("", *TURN_POSITIONS))
        if bool(self.at) != (self.thing is not None):
            raise ValueError("a turn needs both `at` and `thing`, or neither")


@dataclass(frozen=True, slots=True)
class Face:
    """A turn towards a thing, until it is straight ahead."""

    thing: Thing


@dataclass(frozen=True, slots=True)
class Walk:
    """A walk in the current direction or relative to things.

    Attributes:
        way: one of WAYS.
        things: what the walk refers to: none with "ahead", two with "between", otherwise one.
        side: "left" or "right" if the thing's side is stated ("past the bench on your left"), else "".
        count: number of steps if stated ("about five steps"), else 0.
        straight: whether the things are straight ahead, so that a text may say "straight to the bench". Excluded from
            comparison, as it cannot be recovered from a text that does not mention it.
        far: whether the thing is far away when the walk begins, so that a text may say "in the distance". Excluded
            from comparison too.
    """

    way: str
    things: tuple[Thing, ...] = ()
    side: str = ""
    count: int = 0
    straight: bool = field(default=True, compare=False)
    far: bool = field(default=False, compare=False)

    def __post_init__(self) -> None:
        _check("way", self.way, WAYS)
        _check("side", self.side, ("", "left", "right"))
        if self.way == "beside" and not self.side:
            raise ValueError("a walk 'beside' needs a side")
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

    Relations are seen from the agent's tile after these turns: left and right are the agent's, "in front of" is the
    near side of a thing, "behind" the far side.

    Attributes:
        turns: of TURNS, in order; usually none or one.
        thing: the object to place, with its stated attributes; kind "" for a pronoun.
        where: relations of the target cell, which all hold.
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
