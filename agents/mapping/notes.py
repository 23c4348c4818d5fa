"""Notes of agents that keep a map: what was read, and what the agent is about to do."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Protocol

from arramon_client.notes import note_fault, note_text
from arramon_lang.meaning import Assembly, Navigation

Intent = Mapping[str, Any]
"""What an agent is about to do, as plain data. Keys that do not apply are missing.

- "step": number of the instruction's step that is carried out, from 1.
- "goal": [x, z] in units, from the agent's pose at the start of the episode (z ahead, x to the right); in the room
  [column, row].
- "take": the thing that the agent goes for.
- "search": all steps are done, and the object is searched for.
"""


class HasIntent(Protocol):
    """Something that states what the agent is about to do."""

    def intent(self) -> Intent:
        """Return what the agent is about to do."""
        ...


def place(x: float, z: float) -> list[float]:
    """Return a place on the agent's map for a note, rounded to 0.1 units."""
    return [round(x, 1), round(z, 1)]


def outline(value: object) -> Any:
    """Return a meaning, or a part of it, as plain data: attributes that are not stated are left out."""
    if isinstance(value, tuple):
        return [outline(each) for each in value]
    if not is_dataclass(value):
        return value
    stated = {
        field.name: outline(getattr(value, field.name))
        for field in fields(value)
        if field.compare and getattr(value, field.name)
    }
    return {"do": type(value).__name__.lower(), **stated} if type(value).__name__ in STEPS else stated


STEPS = ("Rotate", "Face", "Walk")
"""Names of the classes of steps, which a note states."""


def reading(meaning: Navigation | Assembly) -> dict[str, Any]:
    """Return a meaning for a note: of a very long one only the number of its steps, and the object."""
    read = {"read": outline(meaning)}
    if not note_fault(note_text(read)):
        return read
    if isinstance(meaning, Navigation):
        return {"read": {"steps": len(meaning.steps), "target": {"kind": meaning.target.kind}}}
    return {"read": {"turns": len(meaning.turns), "thing": {"kind": meaning.thing.kind}}}
