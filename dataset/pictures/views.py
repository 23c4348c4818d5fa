"""Contact sheets of the agent's views along the ground truth."""

from collections.abc import Iterator

from PIL import Image

from arramon_dataset.pictures.canvas import WHITE, add_title, stack, wrap_text
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.rules import Limits, State
from arramon_server.sim.section_world import EpisodeWorld

COLUMNS = 8
"""Frames per row of the sheet."""

MAX_FRAMES = 16
"""Maximum number of frames of a phase; longer phases are sampled evenly, with the first and last frames."""


def contact_sheet(episode: Episode, world: EpisodeWorld, size: int = 224) -> Image.Image:
    """Return a sheet of all phases, each with its instruction and frames of `size` pixels in order of steps."""
    parts = []
    for title, states in _phases(episode, world):
        frames = [Image.fromarray(world.render(state, size).rgb) for state in _some(states)]
        parts.append(add_title(_grid(frames, size), title))
    return stack(parts)


def _phases(episode: Episode, world: EpisodeWorld) -> Iterator[tuple[list[str], list[State]]]:
    """Yield, for each phase, its title and the states before each action of the ground truth."""
    session = EpisodeSession(episode, world, Limits(steps_per_phase=10_000))
    language = min(episode.instructions)
    for number, turn in enumerate(episode.turns, start=1):
        for phase, actions in (("navigation", turn.actions), ("assembly", turn.room_actions)):
            text = episode.instruction(language, number, phase)
            title = [f"turn {number}, {phase} ({len(actions)} steps):", *wrap_text(text, COLUMNS * 28)]
            yield title, [before for before, _ in session.replay(actions)]


def _some(states: list[State]) -> list[State]:
    if len(states) <= MAX_FRAMES:
        return states
    return [states[round(i * (len(states) - 1) / (MAX_FRAMES - 1))] for i in range(MAX_FRAMES)]


def _grid(frames: list[Image.Image], size: int) -> Image.Image:
    rows = -(-len(frames) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (size + 4), rows * (size + 4)), WHITE)
    for number, frame in enumerate(frames):
        sheet.paste(frame, ((number % COLUMNS) * (size + 4), (number // COLUMNS) * (size + 4)))
    return sheet
