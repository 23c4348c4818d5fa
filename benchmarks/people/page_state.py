"""What the play page shows a person, as plain text: states, what a key did, and the landing diagram."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arramon_client.world import Action
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, all_texts
from benchmarks.people.reader_folder import LETTERS

KEYS = dict(zip(LETTERS, Action, strict=True))
"""Letter of a key -> its action."""

QUIET = ("moved", "turned", "")
"""Outcomes after which the next key is pressed; at any other the reader looks first."""

COLUMNS, ROWS = 5, 4
"""Size of the room in cells, as the page draws it."""

_ARROWS = {0: "^", 90: ">", 180: "v", 270: "<"}


@dataclass(frozen=True, slots=True)
class Shown:
    """One state of the page with its frame.

    Attributes:
        state: the server's `state` message.
        frame: file with the frame, a JPEG.
        number, episodes: number of the episode in its run, from 1, and the run's number of episodes.
    """

    state: dict[str, Any]
    frame: Path
    number: int
    episodes: int

    @property
    def at(self) -> tuple[str, int]:
        """Episode and step."""
        return self.state["episode"], self.state["step"]


def say(key: str, **values: object) -> str:
    """Return a text of the page's script, in English."""
    return all_texts()[DEFAULT_LANGUAGE](f"play_js.{key}", **values)


def outcome_text(letter: str, state: dict[str, Any]) -> str:
    """Return what a key did, as the page says it; empty if the server does not know it, as after a restart."""
    outcome = state["outcome"]
    if outcome == "turned":
        return say({"L": "turned_left", "R": "turned_right"}[letter])
    return say(outcome, object=_carried(state)) if outcome else ""


def state_text(shown: Shown) -> str:
    """Return the texts beside the frame: instruction, phase, what is carried, steps left, and aids of the run."""
    state = shown.state
    is_room = state["phase"] == "assembly"
    lines = [
        f"Episode {say('progress', number=shown.number, all=shown.episodes)}. "
        f"{say('place_phase' if is_room else 'walk_phase', turn=state['turn'])}",
        f"Instruction: {state['instruction']}",
        f"You carry: {_carried(state) if state['carries'] else say('carries_nothing')}. "
        f"Steps left in this part: {state['steps_left']}",
    ]
    if "heading" in state:
        lines.append(f"Direction: {say('heading', degrees=state['heading'])}")
    if "landing" in state:
        lines += landing_lines(state["landing"])
    return "\n".join([*lines, f"Frame: {shown.frame}"])


def landing_lines(landing: dict[str, Any]) -> list[str]:
    """Return the landing diagram: the room from above, the person as an arrow, X where the object would be placed."""
    cells = [["." for _ in range(COLUMNS)] for _ in range(ROWS)]
    heading, target = landing["heading"], landing["landing"]
    column, row = landing["cell"]
    cells[row][column] = _ARROWS.get(heading, "o")
    if target is None:
        where = say("landing_none")
    else:
        cells[target[1]][target[0]] = "X"
        where = say("landing_cell", column=target[0] + 1, row=target[1] + 1)
    facing = f"you are {cells[row][column]}, facing {heading}° clockwise from the top"
    grid: Sequence[str] = [f"    {' '.join(line)}" for line in reversed(cells)]
    return [f"The room from above ({facing}). The object would be placed at X: {where}", *grid]


def _carried(state: dict[str, Any]) -> str:
    return state["carried"] or say("carries_something")
