"""What kinds of clauses there are: which entry of `phrases.toml` a step is put by, and what fills its slots."""

from collections.abc import Mapping
from dataclasses import dataclass

from lang.meaning import Face, Step, Thing, Turn, Walk, Where

Value = str | Thing | tuple[Where, ...]
"""What fills a slot: an attribute's value, a thing, or relations."""


@dataclass(frozen=True, slots=True)
class Clause:
    """What one clause is to say.

    Attributes:
        key: of `phrases.toml`'s table: "turn", "turn at", "face", "walk past".
        said: what fills each slot that must be filled.
    """

    key: str
    said: Mapping[str, Value]


def clause_of(step: Step) -> Clause:
    """The clause that says a step."""
    if isinstance(step, Turn):
        if step.thing is None:
            return Clause("turn", {"direction": step.direction})
        return Clause(f"turn {step.at}", {"direction": step.direction, "thing": step.thing})
    if isinstance(step, Face):
        return Clause("face", {"thing": step.thing})
    return Clause(f"walk {step.way}", _said_of(step))


def _said_of(walk: Walk) -> dict[str, Value]:
    said: dict[str, Value] = dict(things_said(walk.things))
    if walk.side:
        said["side"] = walk.side
    if walk.count:
        said["count"] = str(walk.count)
    return said


def things_said(things: tuple[Thing, ...]) -> dict[str, Thing]:
    """The slots of one thing, of two, or of a pair of the same ("the two benches")."""
    if len(things) == 2 and things[0] == things[1] and not things[0].where:
        return {"pair": things[0]}
    return dict(zip(("thing", "other"), things, strict=False))


def step_of(key: str, direction: str, things: tuple[Thing, ...], side: str, count: int) -> Step:
    """The step that a clause with that key says; the inverse of `clause_of`.

    Raises:
        ValueError: where something that the step needs is not said.
    """
    kind, _, rest = key.partition(" ")
    if kind == "turn":
        return Turn(direction, rest, things[0] if things else None)
    if kind == "face":
        return Face(*things)
    return Walk(rest, things, side, count)


def focus_of(things: tuple[Thing, ...], before: Thing | None) -> Thing | None:
    """What "it" means after a clause about `things`: the one thing; unclear after two; unchanged after none."""
    if not things:
        return before
    return things[0] if len(things) == 1 else None
