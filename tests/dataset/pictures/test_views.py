"""The contact sheet: each phase's frames, in order, under its instruction."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from arramon_dataset.pictures import views
from arramon_dataset.pictures.views import COLUMNS, contact_sheet
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Limits
from tests import tiny

SIZE = 64


@pytest.fixture
def worlds(tmp_path: Path) -> Iterator[Worlds]:
    split = tiny.write(tmp_path)
    with closing(Worlds({split.name: split})) as worlds:
        yield worlds


def test_contact_sheet_has_one_row_per_phase(worlds: Worlds) -> None:
    sheet = contact_sheet(tiny.episode("0"), worlds.world("tiny", tiny.episode("0")), SIZE)
    assert sheet.width == COLUMNS * (SIZE + 4)
    titles = 2 * 19 + 10  # a line with turn and phase, one with the instruction
    assert sheet.height == 4 * (titles + SIZE + 4 + 8)


def test_frames_are_what_an_agent_sees_along_the_ground_truth(worlds: Worlds) -> None:
    episode = tiny.episode("0")
    world = worlds.world("tiny", episode)
    sheet = np.asarray(contact_sheet(episode, world, SIZE))
    session = EpisodeSession(episode, world, Limits(150))
    top = 0
    for turn in episode.turns:
        for actions in (turn.actions, turn.room_actions):
            top += 2 * 19 + 10
            for number, (state, _) in enumerate(session.replay(actions)):
                left = number * (SIZE + 4)
                frame = world.render(state, SIZE).rgb
                assert (sheet[top : top + SIZE, left : left + SIZE] == frame).all(), (top, number)
            assert (sheet[top : top + SIZE, left + SIZE :] == 255).all()  # and nothing behind the last
            top += SIZE + 4 + 8


@pytest.mark.parametrize(
    ("length", "shown"),
    [(0, []), (1, [0]), (16, [*range(16)]), (31, [*range(0, 31, 2)]), (150, [round(i * 149 / 15) for i in range(16)])],
)
def test_long_phases_show_evenly_spaced_frames_with_the_last(length: int, shown: list[int]) -> None:
    assert views._some([*range(length)]) == shown  # type: ignore[comparison-overlap]
    assert len(shown) <= views.MAX_FRAMES
    assert not shown or (shown[0], shown[-1]) == (0, length - 1)


def test_grid_is_filled_row_by_row() -> None:
    frames = [Image.new("RGB", (SIZE, SIZE), (number, 0, 0)) for number in range(COLUMNS + 2)]
    sheet = views._grid(frames, SIZE)
    assert sheet.size == (COLUMNS * (SIZE + 4), 2 * (SIZE + 4))
    assert [sheet.getpixel((column * (SIZE + 4), 0)) for column in range(COLUMNS)] == [
        (number, 0, 0) for number in range(COLUMNS)
    ]
    assert sheet.getpixel((SIZE + 4, SIZE + 4)) == (COLUMNS + 1, 0, 0)
    assert sheet.getpixel((2 * (SIZE + 4), SIZE + 4)) == (255, 255, 255)
