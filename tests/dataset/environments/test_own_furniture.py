"""Episodes with their own furniture: rendered, solid, known to the expert, and drawn on maps."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arramon_dataset.environments.player import LocalPlayer
from arramon_server.api.messages import oracle_message
from arramon_server.episodes.splits import read_named_split, write_split
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.own_furniture import OwnFurniture
from arramon_server.sim.section import Prop
from tests import tiny
from tests.dataset.environments.players import player

AHEAD, BESIDE = Prop("phone_booth", 0.0, 1.2, 180.0), Prop("kiosk", 1.4, 4.0, 180.0, "red")


@pytest.fixture
def data(tmp_path: Path) -> Path:
    plain = tiny.episode("0", ("en",))
    blocked = replace(tiny.episode("1", ("en",)), furniture=OwnFurniture(added=(AHEAD,)))
    beside = replace(tiny.episode("2", ("en",)), furniture=OwnFurniture(added=(BESIDE,)))
    write_split(
        tmp_path, "tiny", hidden=False, source="tests", episodes=[plain, blocked, beside], sections=[tiny.SECTION]
    )
    return tmp_path


def kinds_seen(made: LocalPlayer, episode_id: str) -> set[str]:
    seen = made.begin(episode_id, 0).segmentation
    assert seen is not None
    return {made.labels[number].kind for number in np.unique(seen)}


def test_each_episode_shows_its_own_furniture(data: Path) -> None:
    made = player(data, sensors=("segmentation",), image_size=64)
    assert "phone_booth" in kinds_seen(made, "1")
    assert "kiosk" in kinds_seen(made, "2")
    assert not {"phone_booth", "kiosk"} & kinds_seen(made, "0")


def test_it_stands_in_the_way(data: Path) -> None:
    made = player(data, sensors=("pose",))
    ends = {}
    for episode_id in ("0", "1", "2"):
        made.begin(episode_id, 0)
        step = made.step(0)
        assert step.observation is not None
        ends[episode_id] = step.observation.pose
    assert ends == {"0": (0.0, 1.0, 0.0), "1": (0.0, 0.0, 0.0), "2": (0.0, 1.0, 0.0)}


def test_the_shortest_way_leads_around_it(data: Path) -> None:
    made = player(data, expert="shortest")
    made.begin("0", 0)
    assert made.expert_action() == 0
    made.begin("1", 0)
    steps = []
    while made.session.state.phase.value == "navigation":
        steps.append(made.expert_action())
        made.step(steps[-1])
    assert steps[0] != 0
    assert made.session.record().turns[0].picked_target


def test_maps_show_it(data: Path) -> None:
    made = player(data)
    maps = []
    for episode_id in ("0", "1", "2"):
        made.begin(episode_id, 0)
        drawn = made.map(96)
        assert drawn is not None
        maps.append(drawn)
    assert not np.array_equal(maps[0], maps[1])
    assert not np.array_equal(maps[1], maps[2])


def test_the_oracle_is_told_of_it(data: Path) -> None:
    split = read_named_split(data, "tiny")
    worlds = Worlds({"tiny": split})
    scenes = {id_: worlds.world("tiny", one).scene for id_, one in split.episodes.items()}
    messages = {id_: oracle_message(one, scenes[id_]).obstacles for id_, one in split.episodes.items()}
    worlds.close()
    assert [len(messages[id_]) for id_ in ("0", "1", "2")] == [1, 2, 2]
    assert (messages["1"][0].x, messages["1"][0].z) == pytest.approx((0.0, 1.2))
