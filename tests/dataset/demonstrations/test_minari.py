"""The Minari datasets, read by Minari."""

from pathlib import Path

import gymnasium
import minari
import numpy as np
import pytest

from tests import tiny
from tests.dataset.demonstrations.exports import expected_observations, export, playing_order


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
        assert (seen["rgb"].dtype, seen["depth"].dtype, seen["segmentation"].dtype) == (np.uint8, np.float32, np.int16)
        for step, expected in enumerate(expected_observations(data, order[number], language)):
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


@pytest.fixture(scope="module")
def both(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An export of both languages to one dataset."""
    folder = tmp_path_factory.mktemp("both")
    export(data, folder, "minari", single_dataset=True)
    return folder


def test_one_dataset_for_both_languages(data: Path, both: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(both))
    assert set(minari.list_local_datasets()) == {"arramon/tiny-en_hi-v0"}
    dataset = minari.load_dataset("arramon/tiny-en_hi-v0")
    assert (dataset.total_episodes, dataset.total_steps) == (10, 10 * len(tiny.ACTIONS))
    described = list(dataset.storage.get_episode_metadata(range(10)))
    said = [(each["episode_id"], each["language"]) for each in described]
    assert len(set(said)) == 10
    assert sorted(id_ for id_, language in said if language == "hi") == sorted(playing_order(data, "hi"))
    for (_, language), episode in zip(said, dataset, strict=True):
        assert episode.observations["instruction"][0] == tiny.episode("1").instruction(language, 1, "navigation")
        assert dataset.observation_space["instruction"].contains(episode.observations["instruction"][0])
        tokens = episode.observations["instruction_tokens"][0]
        assert bytes(int(each) - 3 for each in tokens if each >= 3).decode() == episode.observations["instruction"][0]


def test_its_environment_plays_both_languages(data: Path, both: Path) -> None:
    dataset = minari.MinariDataset(both / "arramon" / "tiny-en_hi-v0" / "data")
    env = dataset.recover_environment(data=str(data))
    assert env.observation_space == dataset.observation_space
    for number, about in enumerate(dataset.storage.get_episode_metadata(range(10))):
        observation, info = env.reset(options={"episode": about["episode_id"], "lang": about["language"]})
        assert info["language"] == about["language"]
        episode = dataset[number]
        for step, action in enumerate(episode.actions):
            for key, value in observation.items():
                assert np.array_equal(value, episode.observations[key][step]), (key, step)
            observation, *_ = env.step(action)
    env.close()


def test_turns_are_one_hot_in_every_dataset(exports: dict[str, Path], both: Path) -> None:
    for folder in (exports["minari"] / "arramon" / "tiny-en-v0", both / "arramon" / "tiny-en_hi-v0"):
        space = minari.MinariDataset(folder / "data").observation_space["turn"]
        assert (space.start, space.n) == (0, 3)
