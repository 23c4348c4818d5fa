"""Whether the reader understood a text as a person does: its reading against the meaning that a reader wrote down.

The written meaning is a list of steps and names in plain words (see `data/README.md`); both sides are brought to one
form, in which words that ask for the same thing are the same.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lang.meaning import Assembly, Face, Navigation, Rotate, Step, Thing, Walk, Where

SAME_WAY = {"to": "towards", "until": "towards", "beside": "past"}
"""Ways of walking that differ only in where they end, within a few steps."""

SAME_KIND = {
    "crossing": "intersection", "crossroads": "intersection", "junction": "intersection", "building_corner": "corner",
    "t-junction": "t_junction", "sidewalk": "street", "road": "street", "wall_corner": "corner", "roadblock": "barrier",
    "tires": "tyre_stack", "tyres": "tyre_stack", "hydrants": "hydrant",
}  # fmt: skip

SAME_COLOUR = {"gold": "gold", "golden": "gold", "wooden": "gold", "gray": "grey", "metal": "silver"}

LOOKS = frozenset(
    {"dotted", "striped", "star", "diamond", "triangle", "circle", "hexagon", "dot"}
    | {"brick", "concrete", "glass", "arched", "spotted", "wood"}
)

ORDINALS = frozenset(["first", "second", "third", "last", "nearest", "next", "another"])

NUMBERS = frozenset(["two", "several", "both", "three"])

Name = tuple[str, str, str]
"""Kind, colour and look; "" for what is not said."""


def navigation_agrees(meaning: Navigation, said: Mapping[str, Any]) -> bool:
    """Return whether a reading has the same steps in the same order, and the same target at the same place."""
    steps = [form for step in meaning.steps if (form := _step(step)) is not None]
    theirs = [form for step in said["steps"] if (form := _said_step(step)) is not None]
    if len(steps) != len(theirs) or not all(map(_fits, steps, theirs)):
        return False
    target = said["target"]
    return _named(_name(meaning.target), name_said(target["thing"])) and _relations_agree(
        meaning.target.where, target["where"]
    )


def assembly_agrees(meaning: Assembly, said: Mapping[str, Any]) -> bool:
    """Return whether a reading has the same turns, the same object, and the same relations of its cell."""
    room = said["room"]
    thing = name_said(room["thing"])
    is_named = not thing[0] or not meaning.thing.kind or _named(_name(meaning.thing), thing)
    return tuple(room["turns"]) == meaning.turns and is_named and _relations_agree(meaning.where, room["where"])


def name_said(words: str) -> Name:
    """Return the kind, colour and look of a thing in the plain words of a written meaning."""
    kind, colour, look = "", "", ""
    for word in words.lower().replace("zebra crossing", "zebra_crossing").split():
        if word in ORDINALS or word in NUMBERS or word == "the":
            continue
        if word in LOOKS:
            look = word
        else:
            colour, kind = (f"{colour} {kind}".strip() if kind else colour), word
    kind = SAME_KIND.get(kind, kind)
    if kind.endswith("s") and kind not in ("hourglass", "bags"):
        kind = SAME_KIND.get(kind[:-1], kind[:-1])
    return kind, SAME_COLOUR.get(colour, colour), look


Form = tuple[str, tuple[str, ...], tuple[Name, ...]]
"""The sort of a step, its words, and the things that it names."""


def _step(step: Step) -> Form | None:
    match step:
        case Rotate(direction, at, thing):
            return "turn", (direction, at), () if thing is None else (_name(thing),)
        case Face(thing):
            return "walk", ("towards", ""), (_name(thing),)
        case Walk("ahead"):
            return None  # That one goes on until the next step applies need not be said.
        case Walk(way, things, side):
            return "walk", (SAME_WAY.get(way, way), side), tuple(map(_name, things))


def _said_step(step: Sequence[Any]) -> Form | None:
    sort, *rest = step
    if sort == "face":
        return "walk", ("towards", ""), _things_said(rest[0])
    if sort == "turn":
        direction, at, thing = [*rest, "", ""][:3]
        return "turn", (direction, at), _things_said(thing)
    way, thing, side = [*rest, "", ""][:3]
    if way == "ahead" and not thing:
        return None
    return "walk", (SAME_WAY.get(way, way), side), _things_said(thing)


def _things_said(said: str | Sequence[str]) -> tuple[Name, ...]:
    names = [said] if isinstance(said, str) else said
    return tuple(name_said(name) for name in names if name)


def _fits(ours: Form, theirs: Form) -> bool:
    return (
        ours[:2] == theirs[:2]
        and len(ours[2]) == len(theirs[2])
        and all(map(_named, sorted(ours[2]), sorted(theirs[2])))
    )


def _named(ours: Name, theirs: Name) -> bool:
    """Return whether two names are of one thing: the same kind and colour, and no other look."""
    return ours[:2] == theirs[:2] and (ours[2] == theirs[2] or not (ours[2] and theirs[2]))


def _name(thing: Thing) -> Name:
    return SAME_KIND.get(thing.kind, thing.kind), SAME_COLOUR.get(thing.colour, thing.colour), thing.look


def _relations_agree(ours: Iterable[Where], theirs: Iterable[Sequence[Any]]) -> bool:
    mine = sorted((each.relation, sorted(map(_name, each.things))) for each in ours)
    said = sorted((relation, sorted(_things_said(things))) for relation, things in theirs)
    return len(mine) == len(said) and all(
        relation == other and len(names) == len(others) and all(map(_named, names, others))
        for (relation, names), (other, others) in zip(mine, said, strict=True)
    )
