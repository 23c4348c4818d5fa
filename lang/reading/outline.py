"""Outlines of navigation instructions: turns and things in the order in which a text names them, understood or not.

A meaning keeps what is understood in full. An outline also keeps the things in between, of which only the name is
understood, and says for each thing how it comes up. It serves to find out where things are from what people say.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from arramon_lang.meaning import Face, Rotate, Step, Thing, Walk, Where
from arramon_lang.reference import things_of

PartMeaning = Step | Thing | Where
"""A part of a text that is understood: a step, the object to pick up, or a relation of it."""

MANNERS = (
    "seen", "faced", "to", "towards", "until", "beside", "past", "between", "along", "at", "before", "after", "target",
)  # fmt: skip
"""How a thing comes up: it is only named; turned to; walked to, and so on as in `meaning.WAYS`; turned at, before or
after it; or the object to pick up has a relation to it."""


@dataclass(frozen=True, slots=True)
class OutlineEntry:
    """A turn, or a mention of a thing.

    Attributes:
        direction: of a turn, one of `meaning.TURNS`; "" for a mention.
        thing: that is mentioned; None for a turn.
        manner: of a mention, one of MANNERS.
        relation: of the object to pick up to the thing, one of `meaning.RELATIONS`, with manner "target"; otherwise "".
        side: "left" or "right" if the thing's side is stated.
        tied: whether it belongs to the same moment as what was said before ("turn left at the bench").
    """

    direction: str = ""
    thing: Thing | None = None
    manner: str = ""
    relation: str = ""
    side: str = ""
    tied: bool = False


def entries_of(part: PartMeaning) -> Iterator[OutlineEntry]:
    """Yield what a part of a text says, in order."""
    if isinstance(part, Where):
        yield from _entries_of_target((part,))
    elif isinstance(part, Thing):
        yield from _entries_of_target(part.where)
    elif isinstance(part, Rotate):
        yield OutlineEntry(direction=part.direction)
        for thing in things_of(part):
            yield OutlineEntry(thing=thing, manner=part.at, tied=True)
    else:
        manner = "faced" if isinstance(part, Face) else part.way
        for thing in things_of(part):
            yield OutlineEntry(thing=thing, manner=manner, side=part.side if isinstance(part, Walk) else "")


def _entries_of_target(wheres: tuple[Where, ...]) -> Iterator[OutlineEntry]:
    for where in wheres:
        for thing in where.things:
            if thing.kind != "you":
                yield OutlineEntry(thing=thing, manner="target", relation=where.relation)
