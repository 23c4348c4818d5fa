"""The in-process player, compared with the server's own worlds and session."""

import sys
from pathlib import Path

import numpy as np
import pytest

from arramon_client.environments.backend import PlayerSettings
from arramon_client.errors import UsageError
from arramon_dataset.environments import LocalBackend
from arramon_dataset.environments.playable_split import open_playable_split
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.labels import LABELS
from tests import tiny
from tests.dataset.environments.players import player
from tests.physics import EACH_CAMERA


@pytest.mark.parametrize("size", [16, 84, 224])
@pytest.mark.parametrize("camera", EACH_CAMERA)
def test_frames_are_those_of_the_worlds(data: Path, size: int, camera: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARRAMON_CAMERA", camera)
    sensors = ("rgb", "depth", "segmentation")
    made = player(data, sensors=sensors, image_size=size)
    worlds = Worlds({"tiny": open_playable_split(data, "tiny", camera).split}, camera)
    into = {
        "rgb": np.zeros((2, size, size, 3), np.uint8)[1],
        "depth": np.zeros((2, size, size), np.float32)[1],
        "segmentation": np.zeros((2, size, size), np.uint16)[1],
    }
    seen = made.begin("1", 0)
    for action in tiny.ACTIONS[:6]:
        frame = worlds.world("tiny", made.session.episode).render(made.session.state, size, segmentation=True)
        for each in (seen, made.latest(into), made.latest()):
            assert each.rgb is not None
            assert each.depth is not None
            assert each.segmentation is not None
            assert frame.segmentation is not None
            assert (each.rgb == frame.rgb).all()
            assert (each.depth == frame.depth.astype(np.float32) * np.float32(0.001)).all()
            assert (each.segmentation == frame.segmentation).all()
        assert (into["rgb"] == frame.rgb).all()
        step = made.step(action)
        assert step.observation is not None
        seen = step.observation
    worlds.close()


def test_what_is_not_wanted_is_not_there(data: Path) -> None:
    every = player(data, sensors=("rgb", "depth", "segmentation")).begin("1", 0)
    for name in ("rgb", "depth", "segmentation"):
        seen = player(data, sensors=(name,)).begin("1", 0)
        for each in ("rgb", "depth", "segmentation"):
            if each == name:
                assert (getattr(seen, each) == getattr(every, each)).all()
            else:
                assert getattr(seen, each) is None


def test_places(data: Path) -> None:
    made = player(data)
    made.begin("1", 0)
    places = [made.place]
    for action in tiny.ACTIONS:
        made.step(action)
        places.append(made.place)
    assert places == ["1"] * 3 + [""] * 2 + ["1"] * 6 + [""] * 3


def test_labels(data: Path) -> None:
    labels = player(data, sensors=("segmentation",)).labels
    assert [(label.kind, label.colour, label.look) for label in labels] == [
        (label.kind, label.colour, label.look) for label in LABELS
    ]
    assert player(data).labels == ()


def test_what_it_refuses(data: Path) -> None:
    made = player(data)
    with pytest.raises(UsageError, match="no episode has begun"):
        made.step(0)
    with pytest.raises(UsageError, match="no episode has begun"):
        made.latest()
    made.begin("1", 0)
    with pytest.raises(UsageError, match="there is no expert: the settings name none"):
        made.expert_action()
    for action in tiny.ACTIONS:
        made.step(action)
    with pytest.raises(ValueError, match="the episode is finished"):
        made.step(0)


def test_a_hidden_split_shows_no_state(tmp_path: Path) -> None:
    tiny.write(tmp_path, "secret", hidden=True)
    made = player(tmp_path, "secret")
    made.begin("1", 0)
    with pytest.raises(UsageError, match="the split 'secret' is hidden"):
        _ = made.session
    assert made.map(64) is not None


def test_players_share_worlds_until_the_data_changes(tmp_path: Path) -> None:
    tiny.write(tmp_path, count=2)
    first = open_playable_split(tmp_path, "tiny", "raster")
    assert open_playable_split(tmp_path, "tiny", "raster") is first
    tiny.write(tmp_path, count=3)
    assert len(open_playable_split(tmp_path, "tiny", "raster").split.episodes) == 3


def test_an_unknown_camera(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARRAMON_CAMERA", "obscura")
    with pytest.raises(UsageError, match="ARRAMON_CAMERA is 'obscura', expected one of raster, tiny"):
        LocalBackend(data)


def test_a_camera_that_is_not_installed(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    monkeypatch.setenv("ARRAMON_CAMERA", "tiny")
    with pytest.raises(UsageError, match=r"ARRAMON_CAMERA is .tiny., which needs pybullet, .*arramon-server.pybullet."):
        LocalBackend(data)


def test_instructions(data: Path) -> None:
    assert set(LocalBackend(data).instructions("tiny", "hi")) == {"धारीदार लाल मग तक चलें।", "उसे दो क़दम आगे रखें।"}
    with pytest.raises(UsageError, match="the split 'sample' has no language 'hi'; it has en"):
        LocalBackend(data).player(PlayerSettings("hi", "sample", (), 32))
