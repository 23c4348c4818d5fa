"""An agent's note of a step, prepared for readers: known keys named in their language, its waypoint on the map.

Notes are texts of strangers: all of it is plain text, to be escaped wherever it is shown.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from arramon.strict_json import NotJsonError, read_json
from arramon_client.world import COLUMNS, ROWS
from arramon_server.web.page_texts import PageTexts

KNOWN = ("step", "take", "search", "goal", "thought", "plan", "noop", "calls", "tokens", "usd", "sight")
"""Keys of notes with a name of their own, in the order in which they are shown."""

MAX_PLACE = 1000.0
"""Largest coordinate of a waypoint that is drawn, in units."""

MAX_READING = 40
"""Largest number of steps of an instruction that are shown as read."""


@dataclass(frozen=True, slots=True)
class ShownNote:
    """A note for readers.

    Attributes:
        facts: name and text of each thing that it states.
        text: the note itself if it states nothing in a known form; otherwise empty.
        goal: the waypoint that it names: (x, z) from the start of the episode, or (column, row); None if none.
        step: number of the instruction's step that is carried out, from 1; 0 if it names none.
        reading: the instruction as the agent read it, one text for each step; empty if it says nothing of it.
    """

    facts: tuple[tuple[str, str], ...]
    text: str = ""
    goal: tuple[float, float] | None = None
    step: int = 0
    reading: tuple[str, ...] = ()


def shown_note(t: PageTexts, note: str) -> ShownNote:
    """Return a note as it is shown in a language."""
    try:
        content = read_json(note)
    except NotJsonError:
        return ShownNote((), note)
    if not isinstance(content, dict) or not content:
        return ShownNote((), note)
    goal = _place(content.get("goal"))
    known = [name for name in KNOWN if name in content and not (name == "goal" and goal)]
    others = [name for name in content if name not in (*KNOWN, "read")]
    facts = [(t.named("notes", name), _fact(name, content[name])) for name in known]
    facts += [(name, _plain(content[name])) for name in others]
    step = content.get("step")
    return ShownNote(
        tuple(facts),
        goal=goal,
        step=step if isinstance(step, int) and not isinstance(step, bool) and step > 0 else 0,
        reading=tuple(_reading(t, content["read"])) if isinstance(content.get("read"), Mapping) else (),
    )


def is_cell(place: tuple[float, float]) -> bool:
    """Return whether a waypoint lies on a cell of the room, as (column, row)."""
    return 0 <= place[0] < COLUMNS and 0 <= place[1] < ROWS


def _place(value: object) -> tuple[float, float] | None:
    if not (isinstance(value, list) and len(value) == 2):
        return None
    if not all(isinstance(one, int | float) and not isinstance(one, bool) and abs(one) < MAX_PLACE for one in value):
        return None
    return float(value[0]), float(value[1])


def _fact(name: str, value: object) -> str:
    if name == "tokens" and isinstance(value, list):
        return " + ".join(map(_plain, value))
    if name == "usd" and isinstance(value, int | float):
        return f"${value:.6f}".rstrip("0").rstrip(".")
    if name == "plan" and isinstance(value, list):
        return ", ".join(map(_plain, value)) or "–"
    return "✓" if value is True else _plain(value)


def _reading(t: PageTexts, read: Mapping[str, Any]) -> Iterator[str]:
    """Yield one text for each step of a read instruction, and one for its object."""
    for key in ("steps", "turns"):
        if isinstance(read.get(key), list):
            yield from (_plain(step) for step in read[key][:MAX_READING])
    for key in ("target", "thing"):
        if key in read:
            yield f"{t('notes.object')}: {_plain(read[key])}"
    rest = {key: value for key, value in read.items() if key not in ("steps", "turns", "target", "thing")}
    rest |= {key: read[key] for key in ("steps", "turns") if key in read and not isinstance(read[key], list)}
    if rest:
        yield _plain(rest)


def _plain(value: object) -> str:
    """Return plain data as text: `walk, past (bench, red)` for {"do": "walk", "past": {"kind": "bench", ...}}."""
    if isinstance(value, Mapping):
        first = [str(value[key]) for key in ("do",) if key in value]
        parts = [_named(str(key), inner) for key, inner in value.items() if key != "do"]
        return ", ".join([*first, *parts])
    if isinstance(value, list):
        return "[" + "; ".join(map(_plain, value)) + "]"
    return "–" if value is None else str(value)


def _named(key: str, value: object) -> str:
    if key in ("kind", "colour", "pattern", "look") and isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return f"{key} ({_plain(value)})"
    return f"{key} {_plain(value)}"
