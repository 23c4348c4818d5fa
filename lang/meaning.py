"""What an instruction means, in no language: what a planner writes, every language says, and a reader gets back.

Words here are the project's own names of things, never words of a language: the data of each language maps its words to
them.
"""

from dataclasses import dataclass

TURNS = ("left", "right", "around", "slightly left", "slightly right")
"""About 90, 90, 180, 30 and 30 degrees."""

WAYS = ("ahead", "to", "towards", "past", "between", "along")
"""Of a walk. "ahead": straight on, until the next step's place comes up (or for `Walk.count` steps). "to": until the
thing is reached. "towards": in its direction, until the next step's place comes up. "past": until it lies behind.
"between": through the gap of two things. "along": keeping beside it."""

ATS = ("at", "before", "after")
"""Where a turn is taken, seen along the way: at the thing, before it is reached, once it has been passed."""

RELATIONS = ("on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near", "against", "diagonal_to")
"""How one thing stands to another; those of the languages' `relations.toml`, and "diagonal_to"."""

PLACES = ("intersection", "corner", "street", "alley", "street_end")
"""Kinds of things that are not solid: a crossing, a building's corner where a street opens, and so on."""

WHICHES = ("", "first", "second", "last", "nearest")


@dataclass(frozen=True, slots=True)
class Thing:
    """Something that can be seen, named as far as the instruction names it.

    Attributes:
        kind: a collectible's ("mug"), street furniture's ("phone_booth", "banner"), "building", "wall", one of PLACES,
            "" where only its attributes are said ("the dotted one"), or "you", the agent itself where it stands ("in
            front of you").
        colour: "red", ...; "" where none is said.
        look: a collectible's pattern ("dotted"), a banner's shape ("star"), a building's facade ("brick"), a wall's
            look ("spotted"); "" where none is said.
        which: one of WHICHES, counted along the way.
        where: how it stands to other things, where that is said ("the bucket in front of the TV").
    """

    kind: str
    colour: str = ""
    look: str = ""
    which: str = ""
    where: tuple["Where", ...] = ()

    def __post_init__(self) -> None:
        _check("which", self.which, WHICHES)


@dataclass(frozen=True, slots=True)
class Where:
    """A relation to one thing, or to two ("between").

    Attributes:
        relation: one of RELATIONS.
        things: the landmarks.
        exactly: whether it is said to be directly so ("directly behind").
    """

    relation: str
    things: tuple[Thing, ...]
    exactly: bool = False

    def __post_init__(self) -> None:
        _check("relation", self.relation, RELATIONS)
        if len(self.things) != (2 if self.relation == "between" else 1):
            raise ValueError(f"{self.relation} of {len(self.things)} things")


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn, here or at a place further on.

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
    """Turn until the thing is straight ahead."""

    thing: Thing


@dataclass(frozen=True, slots=True)
class Walk:
    """Go on.

    Attributes:
        way: one of WAYS.
        things: what it goes by: none with "ahead", two with "between", otherwise one.
        side: "left" or "right" where it is said on which side the thing is then ("past the bench on your left"); or "".
        count: steps, where they are counted ("about five steps"); or 0.
    """

    way: str
    things: tuple[Thing, ...] = ()
    side: str = ""
    count: int = 0

    def __post_init__(self) -> None:
        _check("way", self.way, WAYS)
        _check("side", self.side, ("", "left", "right"))
        if len(self.things) != {"ahead": 0, "between": 2}.get(self.way, 1):
            raise ValueError(f"{self.way} with {len(self.things)} things")


Step = Turn | Face | Walk


@dataclass(frozen=True, slots=True)
class Navigation:
    """A navigation instruction: the steps in order, then what to pick up, and near what it lies.

    Attributes:
        target: what to pick up; `target.where` says what it stands near.
    """

    steps: tuple[Step, ...]
    target: Thing


@dataclass(frozen=True, slots=True)
class Assembly:
    """An assembly instruction: turns first where they are said, then where the object belongs.

    Relations are those an agent sees after these turns, standing on its tile: left and right are its own, "in front of"
    is on its side of the thing, "behind" on the far side.

    Attributes:
        turns: of TURNS, in order; usually none or one.
        thing: what to place, as far as it is named; kind "" for a pronoun.
        where: all of these hold of the cell.
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
