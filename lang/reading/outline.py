"""Outlines of navigation instructions: all turns and mentioned things, in the order of the text.

A meaning keeps only clauses that are fully understood. An outline also keeps things whose clause is not understood, and
says how each thing is mentioned. It serves to locate things from people's descriptions.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from arramon_lang.coreference import things_of
from arramon_lang.meaning import Face, Rotate, Step, Thing, Walk, Where

PartMeaning = Step | Thing | Where
"""Content of a parsed part: a step, the target, or a relation of the target."""

MANNERS = (
    "seen", "faced", "to", "towards", "until", "beside", "past", "between", "along", "at", "before", "after", "target",
)  # fmt: skip
"""How a thing is mentioned: only named ("seen"), faced, walked to (as in `meaning.WAYS`), the place of a turn (as in
`meaning.TURN_POSITIONS`), or a landmark of the target."""


@dataclass(frozen=True, slots=True)
class OutlineEntry:
    """A turn, or a mention of a thing.

    Attributes:
        direction: direction of a turn, one of `meaning.TURNS`; "" for a mention.
        thing: the mentioned thing; None for a turn.
        manner: one of MANNERS for a mention; "" for a turn.
        relation: relation of the target to the thing, one of `meaning.RELATIONS`, if the manner is "target".
        side: "left" or "right" if the thing's side is stated.
        tied: whether it belongs to the same moment as the entry before ("turn left at the bench").
    """

    direction: str = ""
    thing: Thing | None = None
    manner: str = ""
    relation: str = ""
    side: str = ""
    tied: bool = False


def entries_of(part: PartMeaning) -> Iterator[OutlineEntry]:
    """Yield the outline entries of a parsed part, in order."""
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
