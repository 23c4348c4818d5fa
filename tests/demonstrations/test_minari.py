"""The Minari datasets, read by Minari."""

from pathlib import Path

import gymnasium
import minari
import numpy as np
import pytest

from tests import tiny
from tests.demonstrations.exporting import playing_order, simulated


@pytest.mark.parametrize("language", ["en", "hi"])
def test_frames_are_the_simulators(data: Path, exports: dict[str, Path], language: str) -> None:
    dataset = minari.MinariDataset(exports["minari"] / "arramon" / f"tiny-{language}-v0" / "data")
    order = playing_order(data, language)
    assert dataset.total_episodes == len(order)
    assert dataset.total_steps == len(order) * len(tiny.ACTIONS)
    assert not dataset.storage.jpeg_encoding
    for number in (0, len(order) - 1):
        episode = dataset[number]
        assert episode.actions.tolist() == list(tiny.ACTIONS)
        assert episode.terminations.tolist() == [*[False] * (len(tiny.ACTIONS) - 1), True]
        assert not episode.truncations.any()
        assert episode.rewards.sum() == pytest.approx(4.0)
        seen = episode.observations
        assert (seen["rgb"].dtype, seen["depth"].dtype, seen["segmentation"].dtype) == (np.uint8, np.float32, np.uint16)
        for step, expected in enumerate(simulated(data, order[number], language)):
            for sensor in ("rgb", "depth", "segmentation"):
                assert (seen[sensor][step] == getattr(expected, sensor)).all(), (sensor, step)
            assert tuple(seen["pose"][step]) == expected.pose
            assert seen["instruction"][step] == expected.instruction
            assert seen["turn"][step] == expected.turn
            assert seen["steps_left"][step] == expected.steps_left
        assert (seen["rgb"][-1] == seen["rgb"][-2]).all()
        assert seen["last_action"].tolist() == [4, *tiny.ACTIONS]
    (metadata,) = dataset.storage.get_episode_metadata([0])
    assert metadata["episode_id"] == order[0]
    assert metadata["cause"] == "AGENT_FINISHED"
    assert metadata["scores"]["turn 1"]["PTC"] == 1.0


def test_the_environment_can_be_made_again(data: Path, exports: dict[str, Path]) -> None:
    dataset = minari.MinariDataset(exports["minari"] / "arramon" / "tiny-hi-v0" / "data")
    env = dataset.recover_environment(data=str(data))
    assert env.observation_space == dataset.observation_space
    assert env.action_space == dataset.action_space
    order = playing_order(data, "hi")
    observation, _ = env.reset(options={"episode": order[1]})
    episode = dataset[1]
    for step, action in enumerate(episode.actions):
        for key, value in observation.items():
            assert np.array_equal(value, episode.observations[key][step]), (key, step)
        observation, reward, terminated, _, _ = env.step(action)
        assert reward == episode.rewards[step]
        assert terminated == episode.terminations[step]
    env.close()


def test_minari_lists_them(exports: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(exports["minari"]))
    assert set(minari.list_local_datasets()) == {"arramon/tiny-en-v0", "arramon/tiny-hi-v0"}
    assert isinstance(minari.load_dataset("arramon/tiny-en-v0").action_space, gymnasium.spaces.Discrete)
