"""What a writer sees: an agent's frame, and in it the line, the arrow and the outlined object, nothing else changed."""

from pathlib import Path

import numpy as np
import pytest

from arramon_collecting.writing.guide import BLUE, guide_of
from arramon_collecting.writing.pictures import WriterPictures
from arramon_collecting.writing.walk import begin, read_position, state_at
from arramon_server.runs.play.worlds import Worlds
from tests import tiny

SIZE = 96


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> WriterPictures:
    return WriterPictures({"tiny": tiny.write(tmp_path_factory.mktemp("data"), count=1)})


def plain(position: str, data: Path) -> np.ndarray:
    """The frame that an agent gets there."""
    split = tiny.write(data, count=1)
    episode = split.episodes["0"]
    world = Worlds({"tiny": split}).world("tiny", episode)
    return world.render(state_at(read_position(position, episode), episode), SIZE).rgb


def seen(pictures: WriterPictures, position: str) -> np.ndarray:
    episode = tiny.episode("0", ("en",))
    return pictures.draw("tiny", episode, read_position(position, episode), SIZE)


def is_blue(picture: np.ndarray) -> np.ndarray:
    """(size, size) bool: where a picture has the line's colour, in any light."""
    light = picture.astype(int)
    return (light[..., 2] > 100) & (light[..., 0] * BLUE[2] < light[..., 2] * (BLUE[0] + 12)) & (light[..., 1] > 25)


def test_the_line_leads_ahead_and_the_arrow_stands_above_the_target(pictures: WriterPictures, tmp_path: Path) -> None:
    guided, frame = seen(pictures, "0.0.0.2.0.0"), plain("0.0.0.2.0.0", tmp_path)
    changed = (guided != frame).any(axis=2)
    rows, columns = np.nonzero(changed & is_blue(guided))
    assert rows.min() > SIZE / 2, "the line is below the horizon"
    assert abs(columns.mean() - SIZE / 2) < 3
    rows, columns = np.nonzero(changed & (guided[..., 0] > 2 * guided[..., 1].astype(int)) & ~is_blue(guided))
    assert rows.max() < SIZE / 2 + 6, "the arrow is above the mug"
    assert abs(columns.mean() - SIZE / 2) < 2


def test_looking_away_from_the_line_shows_what_an_agent_sees(pictures: WriterPictures, tmp_path: Path) -> None:
    assert np.array_equal(seen(pictures, "0.0.9.2.0.0"), plain("0.0.9.2.0.0", tmp_path))


def test_the_room_shows_the_object_as_a_dark_see_through_shape(pictures: WriterPictures, tmp_path: Path) -> None:
    outlined, frame = seen(pictures, "1.0.0.2.0.1"), plain("1.0.0.2.0.1", tmp_path)
    changed = (outlined != frame).any(axis=2)
    assert 40 < changed.sum() < SIZE * SIZE / 8
    assert (outlined[changed].astype(int) <= frame[changed]).all(), "it only darkens"
    assert (outlined[changed] == 0).all(axis=1).any(), "its edge is black"
    assert (outlined[changed] > 0).any(), "what is behind it shines through"


@pytest.mark.parametrize("position", ["1.0.6.2.0.1", "1.0.0.2.2.1"], ids=["behind", "on its cell"])
def test_the_room_is_an_agents_where_the_place_is_not_in_sight(
    pictures: WriterPictures, tmp_path: Path, position: str
) -> None:
    assert np.array_equal(seen(pictures, position), plain(position, tmp_path))


def test_the_guide_stands_in_nobodys_way() -> None:
    bodies = guide_of(tiny.episode("0").turns[0])
    assert len(bodies) == 3 + 2 + 1
    assert {body.collider for body in bodies} == {None}
    assert len({body.name for body in bodies}) == len(bodies)


def test_cached_streets_belong_to_their_episode(pictures: WriterPictures) -> None:
    """Another episode of the same id, as after a correction, is drawn anew."""
    first = tiny.episode("0", ("en",))
    before = pictures.draw("tiny", first, begin(first), SIZE)
    other = tiny.episode("0", ("en",))
    assert np.array_equal(pictures.draw("tiny", other, begin(other), SIZE), before)
