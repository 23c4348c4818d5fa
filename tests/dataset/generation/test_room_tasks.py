"""The split of room tasks without a city."""

from pathlib import Path

import gymnasium
import pytest

import arramon_client.environments  # noqa: F401 - registers the environments
import arramon_lang as lang
from arramon_dataset.generation import room_tasks
from arramon_dataset.generation.command import generate_rooms
from arramon_dataset.generation.room_tasks import RoomBatch
from arramon_dataset.generation.split_maker import GenerationProgress
from arramon_dataset.instructions.gate import assembly as gate_assembly
from arramon_server.commands.split_description import describe_split
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.errors import BadInput


def make(data: Path, count: int, *, seed: int = 1, jobs: int = 1) -> tuple[Split, list[GenerationProgress]]:
    reported: list[GenerationProgress] = []
    return generate_rooms(data, count, seed=seed, jobs=jobs, on_progress=reported.append), reported


def test_it_is_for_training_and_in_every_language(tmp_path: Path) -> None:
    split, _ = make(tmp_path, 5)

    assert split.languages == dict.fromkeys(lang.required(), 5)
    assert split.training
    assert list(split.episodes) == [f"room-{number}" for number in range(5)]
    assert split.source == "generated, room tasks alone, seed 1, not tried by the follower"
    assert describe_split(split).startswith("split rooms (for training alone): 5 in en, 5 in hi; 1 section; data ")


def test_number_of_jobs_does_not_change_it_and_a_smaller_one_is_a_prefix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The seed changes it."""
    monkeypatch.setattr(room_tasks, "BATCH_SIZE", 3)
    whole, reported = make(tmp_path / "one", 5)
    again, _ = make(tmp_path / "two", 5, jobs=2)
    part, _ = make(tmp_path / "part", 2)
    other, _ = make(tmp_path / "other", 2, seed=2)

    assert whole.data_hash == again.data_hash
    assert [progress.done for progress in reported] == [0, 3, 5]
    assert list(whole.episodes.values())[:2] == list(part.episodes.values())
    assert all(part.episodes[name].decoys != other.episodes[name].decoys for name in part.episodes)


def test_the_room_environment_plays_it(tmp_path: Path) -> None:
    make(tmp_path, 3)
    env = gymnasium.make("arramon/ArraMonRoom-v0", data=tmp_path, lang="hi", image_size=64, expert="reference")
    for number in range(3):
        observation, info = env.reset(options={"episode": f"room-{number}"})
        episode = read_split(split_folder(tmp_path, "rooms")).episodes[f"room-{number}"]
        assert observation["instruction"] == episode.instruction("hi", 1, "assembly")
        terminated = False
        while not terminated:
            assert observation["phase"] == 1
            observation, _, terminated, _, info = env.step(info["expert_action"])
        assert info["scores"]["total"]["PTC"] == 1.0
    env.close()


def test_drafts_whose_texts_are_not_true_are_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gate that refuses the first draft of each task makes each take another."""
    plain = RoomBatch(1, ("room-0", "room-1")).generate()
    asked: list[object] = []

    def refuse_first(meaning: object, *others: object) -> object:
        asked.append(meaning)
        return ("false",) if len(asked) == 1 else gate_assembly.faults_of_assembly(meaning, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(room_tasks, "faults_of_assembly", refuse_first)
    (first, second) = RoomBatch(1, ("room-0", "room-1")).generate()

    assert first.attempts > plain[0].attempts
    assert first.episode.decoys != plain[0].episode.decoys
    assert second == plain[1]


def test_no_tasks_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="the number of room tasks is 0; expected at least 1"):
        make(tmp_path, 0)
