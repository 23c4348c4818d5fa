"""What a model reads and writes: an observation as text and picture, actions by name."""

import base64
import io
from collections.abc import Sequence

from arramon_client.adapters.extras import extra
from arramon_client.agent import Observation
from arramon_client.errors import UsageError
from arramon_client.world import Action

ACTION_NAMES = tuple(action.name.lower() for action in Action)
"""Names of the actions, in order of their numbers: "forward", "left", "right", "interact"."""

MAX_ACTIONS = 10
"""Largest number of actions in one act of a model."""

RULES = f"""\
You move through a street, and later through a room, and follow instructions. An episode has two turns, each with two
phases. Navigation: follow the instruction through the street to an object, and pick it up with "interact" when it is
right ahead of you. Assembly: put the object down in the room where the instruction says, with "interact" when the cell
is right ahead of you. Actions: "forward" (one step; in the room one cell, if you face along a row or column), "left"
and "right" (turns by 30 degrees), "interact". Each act has 1 to {MAX_ACTIONS} actions; it stops early if something
unexpected happens, for example if a wall is in the way."""
"""What a model is told before an episode."""


def observation_text(seen: Observation, stop_reason: str = "") -> str:
    """Return what an observation says, apart from its pictures.

    Args:
        seen: the observation.
        stop_reason: why the act before stopped early; empty if it did not.
    """
    stopped = f"Your act stopped early: {stop_reason}.\n" if stop_reason else ""
    seconds = seen.seconds_left()
    clock = "" if seconds is None else f", {seconds:.0f} seconds until the episode times out"
    return (
        f"{stopped}Step {seen.step}: turn {seen.turn} of 2, {seen.phase} phase, {seen.steps_left} steps left in it"
        f"{clock}.\nInstruction: {seen.instruction}"
    )


def actions_of(names: Sequence[str]) -> list[int]:
    """Return the numbers of actions.

    Raises:
        UsageError: if a name is unknown, or there are none or too many.
    """
    expected = f"expected 1 to {MAX_ACTIONS} of {', '.join(ACTION_NAMES)}"
    if isinstance(names, str) or not 1 <= len(names) <= MAX_ACTIONS:
        raise UsageError(f"actions are {names!r}, {expected}")
    for name in names:
        if name not in ACTION_NAMES:
            raise UsageError(f"there is no action {name!r}, {expected}")
    return [ACTION_NAMES.index(name) for name in names]


def picture(seen: Observation) -> bytes | None:
    """Return what the agent sees as a PNG file; None without the sensor "rgb".

    Raises:
        UsageError: if Pillow is not installed.
    """
    if seen.rgb is None:
        return None
    with extra("pictures"):
        from PIL import Image
    stream = io.BytesIO()
    Image.fromarray(seen.rgb).save(stream, "PNG")
    return stream.getvalue()


def picture_url(seen: Observation) -> str | None:
    """Return the picture as a data URL; None without the sensor "rgb"."""
    png = picture(seen)
    return None if png is None else f"data:image/png;base64,{base64.b64encode(png).decode()}"
