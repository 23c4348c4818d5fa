"""Conversion between meanings and rows of categorical slots, which are the output of the learned reader.

A row is a step, the object to pick up, the object to place, or a relation of a thing named in an earlier row.
"""

from collections.abc import Sequence
from dataclasses import replace

from arramon_agents.perception.eyes.vocabulary import COLOURS, LOOK_GROUPS
from arramon_client.world import COLLECTIBLES, FURNITURE
from arramon_lang.meaning import (
    NUMBERS,
    PLACES,
    RELATIONS,
    TURN_POSITIONS,
    TURNS,
    WAYS,
    WHICHES,
    Assembly,
    Face,
    Meaning,
    Navigation,
    Rotate,
    Step,
    Thing,
    Walk,
    Where,
)

END, ROTATE, FACE, WALK, TARGET, PLACE, WHERE = TYPES = ("end", "rotate", "face", "walk", "target", "place", "where")

MAX_WALK_STEPS = 12
"""Maximum of a walk's number of steps; larger numbers are clipped to it."""

_KINDS = ("", *COLLECTIBLES, *FURNITURE, "building", "wall", *PLACES, "you")
_COLOURS = ("", *COLOURS)
_LOOKS = ("", *dict.fromkeys(look for group in LOOK_GROUPS for look in group.looks))

SLOTS: dict[str, tuple[str, ...]] = {
    "type": TYPES,
    "direction": ("", *TURNS),
    "at": ("", *TURN_POSITIONS),
    "way": ("", *WAYS),
    "side": ("", "left", "right"),
    "count": tuple(map(str, range(MAX_WALK_STEPS + 1))),
    "relation": ("", *RELATIONS),
    "exactly": ("", "exactly"),
    **{
        f"{name}{number}": values
        for number in (1, 2)
        for name, values in (
            ("kind", _KINDS),
            ("colour", _COLOURS),
            ("look", _LOOKS),
            ("which", WHICHES),
            ("number", NUMBERS),
        )
    },
}
"""Values of each slot; the first value means "unused"."""

ACTION_SLOTS = tuple(SLOTS)[:8]
THING_SLOTS = tuple(tuple(name for name in SLOTS if name.endswith(str(number))) for number in (1, 2))

MAX_ROWS = 20
"""Maximum number of rows of an instruction."""

Row = tuple[int, ...]
"""Value ids of a row, one for each slot."""

EMPTY: Row = (0,) * len(SLOTS)


def rows_of(meaning: Meaning) -> list[Row]:
    """Return a meaning's rows, without the end row.

    Relations of things in relations, and of the second of two things, are left out.

    Raises:
        ValueError: if a value is not among the slots' values, or there are too many rows.
    """
    rows: list[Row] = []
    if isinstance(meaning, Navigation):
        for step in meaning.steps:
            rows += _step_rows(step)
        rows += _named(TARGET, meaning.target)
    else:
        rows += [_row(type=ROTATE, direction=turn) for turn in meaning.turns]
        rows += _named(PLACE, replace(meaning.thing, where=meaning.where))
    if len(rows) >= MAX_ROWS:
        raise ValueError(f"{len(rows)} rows; expected less than {MAX_ROWS}")
    return rows


def meaning_of(rows: Sequence[Row], phase: str) -> Meaning:
    """Return the meaning of rows; inconsistent rows are ignored.

    Args:
        rows: without the end row.
        phase: "navigation" or "assembly".
    """
    steps: list[Step] = []
    target = Thing("")
    for row, relations in _grouped(rows):
        values = _values(row)
        things = tuple(_thing(values, number) for number in (1, 2))
        first = replace(things[0], where=tuple(relations))
        if values["type"] in (TARGET, PLACE):
            target = first
            break
        step = _step(values, (first, things[1]))
        if step is not None:
            steps.append(step)
    if phase == "navigation":
        return Navigation(tuple(steps), target)
    turns = tuple(step.direction for step in steps if isinstance(step, Rotate))
    return Assembly(turns, replace(target, where=()), target.where)


def _step_rows(step: Step) -> list[Row]:
    if isinstance(step, Rotate):
        if step.thing is None:
            return [_row(type=ROTATE, direction=step.direction)]
        return _named(ROTATE, step.thing, direction=step.direction, at=step.at)
    if isinstance(step, Face):
        return _named(FACE, step.thing)
    said = {"way": step.way, "side": step.side, "count": str(min(step.count, MAX_WALK_STEPS))}
    if not step.things:
        return [_row(type=WALK, **said)]
    second = step.things[1] if len(step.things) > 1 else None
    return _named(WALK, step.things[0], second, **said)


def _named(type_: str, thing: Thing, other: Thing | None = None, **said: str) -> list[Row]:
    """Return the row that names a thing, and those of its relations."""
    rows = [_row(type=type_, **said, **_slots_of(thing, 1), **(_slots_of(other, 2) if other else {}))]
    for where in thing.where:
        slots = [_slots_of(one, number) for number, one in enumerate(where.things, start=1)]
        exactly = "exactly" if where.exactly else ""
        rows.append(
            _row(type=WHERE, relation=where.relation, exactly=exactly, **{k: v for s in slots for k, v in s.items()})
        )
    return rows


def _slots_of(thing: Thing, number: int) -> dict[str, str]:
    named = {
        "kind": thing.kind, "colour": thing.colour, "look": thing.look, "which": thing.which, "number": thing.number,
    }  # fmt: skip
    return {f"{name}{number}": value for name, value in named.items()}


def _row(**said: str) -> Row:
    for name, value in said.items():
        if value not in SLOTS[name]:
            raise ValueError(f"{name} {value!r} is not one of {', '.join(map(repr, SLOTS[name]))}")
    return tuple(values.index(said[name]) if name in said else 0 for name, values in SLOTS.items())


def _values(row: Row) -> dict[str, str]:
    return {name: values[number] for (name, values), number in zip(SLOTS.items(), row, strict=True)}


def _grouped(rows: Sequence[Row]) -> list[tuple[Row, list[Where]]]:
    """Return each row with the relations after it."""
    grouped: list[tuple[Row, list[Where]]] = []
    for row in rows:
        values = _values(row)
        if values["type"] == END:
            break
        if values["type"] != WHERE:
            grouped.append((row, []))
        elif grouped and values["relation"]:
            count = 2 if values["relation"] == "between" else 1
            things = tuple(_thing(values, number) for number in range(1, count + 1))
            grouped[-1][1].append(Where(values["relation"], things, bool(values["exactly"])))
    return grouped


def _thing(values: dict[str, str], number: int) -> Thing:
    kind, colour, look, which, count = (
        values[f"{name}{number}"] for name in ("kind", "colour", "look", "which", "number")
    )
    return Thing(kind, colour, look, which, number=count)


def _step(values: dict[str, str], things: tuple[Thing, Thing]) -> Step | None:
    """Return the step of a row; None if its slots are inconsistent."""
    named = bool(things[0].kind or things[0].colour or things[0].look)
    if values["type"] == ROTATE and values["direction"]:
        if values["at"] and named:
            return Rotate(values["direction"], values["at"], things[0])
        return Rotate(values["direction"])
    if values["type"] == FACE and named:
        return Face(things[0])
    way = values["way"]
    if values["type"] != WALK or not way or (way == "beside" and not values["side"]):
        return None
    count = {"ahead": 0, "between": 2}.get(way, 1)
    return Walk(way, things[:count], values["side"], int(values["count"])) if named or not count else None
