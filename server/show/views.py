"""What the agent sees along the ground truth, as a contact sheet."""

from collections.abc import Iterator

from PIL import Image

from server.episodes.episode import Episode
from server.runs.session import Session
from server.runs.worlds import Worlds
from server.show.canvas import WHITE, stacked, titled, wrapped
from server.sim.rules import Limits, State

COLUMNS = 8
"""Frames in a row of the sheet."""

MOST = 16
"""Frames of a phase on the sheet; of a longer phase some are left out, evenly, never the last."""


def contact_sheet(episode: Episode, split: str, worlds: Worlds, size: int = 224) -> Image.Image:
    """Both turns and phases, each under its instruction: frames of `size` pixels, numbered by step from the left."""
    parts = []
    for title, states in _phases(episode, split, worlds):
        frames = [Image.fromarray(worlds.render(split, episode, state, size).rgb) for state in _some(states)]
        parts.append(titled(_grid(frames, size), title))
    return stacked(parts)


def _phases(episode: Episode, split: str, worlds: Worlds) -> Iterator[tuple[list[str], list[State]]]:
    """For each phase its title and the states in which the ground truth acts, in order."""
    session = Session(episode, worlds.ground(split, episode.section), Limits(steps_per_phase=10_000))
    language = min(episode.instructions)
    for number, turn in enumerate(episode.turns, start=1):
        for phase, actions in (("navigation", turn.actions), ("assembly", turn.room_actions)):
            text = episode.instruction(language, number, phase)
            title = [f"turn {number}, {phase} ({len(actions)} steps):", *wrapped(text, COLUMNS * 28)]
            yield title, [before for before, _ in session.replay(actions)]


def _some(states: list[State]) -> list[State]:
    if len(states) <= MOST:
        return states
    return [states[round(i * (len(states) - 1) / (MOST - 1))] for i in range(MOST)]


def _grid(frames: list[Image.Image], size: int) -> Image.Image:
    rows = -(-len(frames) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (size + 4), rows * (size + 4)), WHITE)
    for number, frame in enumerate(frames):
        sheet.paste(frame, ((number % COLUMNS) * (size + 4), (number // COLUMNS) * (size + 4)))
    return sheet
