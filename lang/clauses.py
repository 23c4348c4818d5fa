"""Conversion between steps and clauses: the key in `phrases.toml` that expresses a step, and its slots' values."""

from collections.abc import Mapping
from dataclasses import dataclass

from arramon_lang.meaning import Face, Rotate, Step, Thing, Walk, Where

Value = str | Thing | tuple[Where, ...]
"""A slot's value: an attribute's value, a thing, or relations."""


@dataclass(frozen=True, slots=True)
class Clause:
    """The content of one clause.

    Attributes:
        key: key in the table of `phrases.toml`: "turn", "turn at", "face", "walk past".
        slots: value of each slot that must be filled.
        straight: whether its thing is straight ahead, so that the clause may say so.
        far: whether its thing is far away, so that the clause may say so.
    """

    key: str
    slots: Mapping[str, Value]
    straight: bool = True
    far: bool = False


def clause_of(step: Step) -> Clause:
    """Return the clause that expresses a step."""
    if isinstance(step, Rotate):
        if step.thing is None:
            return Clause("turn", {"direction": step.direction})
        return Clause(f"turn {step.at}", {"direction": step.direction, **thing_slots((step.thing,))})
    if isinstance(step, Face):
        return Clause("face", thing_slots((step.thing,)))
    return Clause(f"walk {step.way}", _walk_slots(step), step.straight, step.far)


def _walk_slots(walk: Walk) -> dict[str, Value]:
    slots: dict[str, Value] = dict(thing_slots(walk.things))
    if walk.side:
        slots["side"] = walk.side
    if walk.count:
        slots["count"] = str(walk.count)
    return slots


def thing_slots(things: tuple[Thing, ...]) -> dict[str, Thing]:
    """Return the slots of one thing, of two, of a pair of equal things ("the two benches"), or of several."""
    if len(things) == 2 and things[0] == things[1] and not things[0].where:
        return {"pair": things[0]}
    if len(things) == 1 and things[0].number:
        return {"pair" if things[0].number == "two" else "several": things[0]}
    return dict(zip(("thing", "other"), things, strict=False))


def step_of(key: str, direction: str, things: tuple[Thing, ...], side: str, count: int) -> Step:
    """Return the step that a clause with that key expresses; the inverse of `clause_of`.

    Raises:
        ValueError: if something that the step needs is missing.
    """
    kind, _, rest = key.partition(" ")
    if kind == "turn":
        return Rotate(direction, rest, things[0] if things else None)
    if kind == "face":
        return Face(*things)
    return Walk(rest, things, side, count)


def focus_after(things: tuple[Thing, ...], before: Thing | None) -> Thing | None:
    """Return the referent of "it" after a clause: its only thing, None if it has several, unchanged if it has none."""
    if not things:
        return before
    return things[0] if len(things) == 1 and not things[0].number else None
