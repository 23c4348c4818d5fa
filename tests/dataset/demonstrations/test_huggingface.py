"""The Hugging Face dataset, read by `datasets`."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import yaml

from tests import tiny
from tests.dataset.demonstrations.exports import SIZE, expected_observations, playing_order

if TYPE_CHECKING:
    import datasets


@pytest.fixture(scope="module")
def loaded(exports: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> "datasets.DatasetDict":
    import datasets  # takes half a second, which no process is to spend that has none of these tests

    cache = tmp_path_factory.mktemp("cache")
    return datasets.load_dataset(str(exports["huggingface"]), cache_dir=str(cache))


def test_splits_are_languages(data: Path, loaded: "datasets.DatasetDict") -> None:
    import datasets

    assert {name: split.num_rows for name, split in loaded.items()} == {
        code: len(playing_order(data, code)) * len(tiny.ACTIONS) for code in ("en", "hi")
    }
    features = loaded["en"].features
    assert isinstance(features["rgb"], datasets.Image)
    assert features["depth"] == datasets.Array2D(shape=(SIZE, SIZE), dtype="float32")
    assert features["segmentation"] == datasets.Array2D(shape=(SIZE, SIZE), dtype="uint16")
    assert features["action"].names == ["forward", "left", "right", "interact"]


@pytest.mark.parametrize("language", ["en", "hi"])
def test_frames_are_the_simulators(data: Path, loaded: "datasets.DatasetDict", language: str) -> None:
    rows = loaded[language].with_format("numpy")
    order = playing_order(data, language)
    for number in (0, len(order) - 1):
        for step, expected in enumerate(expected_observations(data, order[number], language)):
            row = rows[number * len(tiny.ACTIONS) + step]
            assert (row["episode_id"], row["step"], row["action"]) == (order[number], step, tiny.ACTIONS[step])
            for sensor in ("rgb", "depth", "segmentation"):
                assert (row[sensor] == getattr(expected, sensor)).all(), (sensor, step)
            assert (row["rgb"].dtype, row["depth"].dtype) == (np.uint8, np.float32)
            assert tuple(row["pose"]) == expected.pose
            assert row["instruction"] == expected.instruction
            assert (row["turn"], row["steps_left"]) == (expected.turn, expected.steps_left)
            assert loaded[language].features["phase"].int2str(int(row["phase"])) == expected.phase
            assert bool(row["terminated"]) == (step == len(tiny.ACTIONS) - 1)
            assert not row["truncated"]
    assert np.sum(rows[: len(tiny.ACTIONS)]["reward"]) == pytest.approx(4.0)


def test_the_card_has_the_metadata_of_hubs(exports: dict[str, Path]) -> None:
    text = (exports["huggingface"] / "README.md").read_text()
    metadata = yaml.safe_load(text.split("---\n")[1])
    assert metadata["language"] == ["en", "hi"]
    assert [each["split"] for each in metadata["configs"][0]["data_files"]] == ["en", "hi"]
    assert "| `depth` | float32: units along the viewing direction" in text
