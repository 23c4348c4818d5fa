"""The LeRobot dataset: by LeRobot itself where it is installed, and against its published layout in any case.

https://huggingface.co/docs/lerobot/lerobot-dataset-v3 describes the layout.
"""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from PIL import Image

from tests import tiny
from tests.dataset.demonstrations.exports import SIZE, ExpectedObservation, expected_observations, playing_order

STEPS = len(tiny.ACTIONS)


def expected_episodes(data: Path) -> list[tuple[str, str]]:
    """(Episode id, language) in order: all languages of an episode one after another."""
    hindi = playing_order(data, "hi")
    return [(id_, code) for id_ in playing_order(data, "en") for code in ("en", "hi") if code == "en" or id_ in hindi]


def rows_of(folder: Path) -> "pd.DataFrame":
    files = sorted((folder / "data").glob("*/*.parquet"))
    return pd.concat([pq.read_table(file).to_pandas() for file in files], ignore_index=True)


def check_frame(row: Any, expected: ExpectedObservation) -> None:
    picture = np.asarray(Image.open(io.BytesIO(row["observation.images.rgb"]["bytes"])))
    assert (picture == expected.rgb).all()
    depth = np.stack(row["observation.depth"])
    assert depth.dtype == np.float32
    assert (depth == expected.depth).all()
    assert (np.stack(row["observation.segmentation"]) == expected.segmentation).all()
    assert tuple(row["observation.state"]) == expected.pose


def test_frames_are_the_simulators(data: Path, exports: dict[str, Path]) -> None:
    rows = rows_of(exports["lerobot"])
    tasks = pd.read_parquet(exports["lerobot"] / "meta" / "tasks.parquet")
    episodes = expected_episodes(data)
    assert len(rows) == len(episodes) * STEPS
    for number in (0, 1, len(episodes) - 1):
        for step, expected in enumerate(expected_observations(data, *episodes[number])):
            row = rows.iloc[number * STEPS + step]
            check_frame(row, expected)
            assert (row["episode_index"], row["frame_index"], row["timestamp"]) == (number, step, float(step))
            assert row["action"] == tiny.ACTIONS[step]
            assert tasks.iloc[row["task_index"]].name == expected.instruction
            assert row["next.done"] == (step == STEPS - 1)
    assert rows["index"].tolist() == list(range(len(rows)))


def test_layout(data: Path, exports: dict[str, Path]) -> None:
    """What LeRobot's reader relies on: paths by format strings, counts, and where each episode's rows are."""
    folder = exports["lerobot"]
    info = json.loads((folder / "meta" / "info.json").read_text())
    episodes = expected_episodes(data)
    assert info["codebase_version"] == "v3.0"
    assert (info["total_episodes"], info["total_frames"]) == (len(episodes), len(episodes) * STEPS)
    assert info["splits"] == {"train": f"0:{len(episodes)}"}
    assert info["features"]["observation.images.rgb"] == {
        "dtype": "image",
        "shape": [SIZE, SIZE, 3],
        "names": ["height", "width", "channels"],
        "info": {"dtype": "uint8", "unit": "red, green and blue, 0 to 255"},
    }
    assert info["features"]["observation.depth"]["info"]["unit"].startswith("units along the viewing direction")
    tasks = pd.read_parquet(folder / "meta" / "tasks.parquet")
    assert tasks["task_index"].tolist() == list(range(info["total_tasks"]))
    table = pd.concat(map(pd.read_parquet, sorted((folder / "meta" / "episodes").glob("*/*.parquet"))))
    assert list(zip(table["episode_id"], table["language"], strict=True)) == episodes
    for episode in table.to_dict("records"):
        place = {name: episode[f"data/{name}"] for name in ("chunk_index", "file_index")}
        rows = pq.read_table(folder / info["data_path"].format(**place)).to_pandas()
        own = rows[rows["episode_index"] == episode["episode_index"]]
        assert own["index"].tolist() == list(range(episode["dataset_from_index"], episode["dataset_to_index"]))
        assert len(own) == episode["length"]
        assert list(episode["tasks"]) == [tasks.iloc[i].name for i in dict.fromkeys(own["task_index"])]
    columns = set(pq.read_schema(next((folder / "data").glob("*/*.parquet"))).names)
    assert columns == set(info["features"])


def test_statistics_have_the_shapes_that_normalisation_expects(exports: dict[str, Path]) -> None:
    stats = json.loads((exports["lerobot"] / "meta" / "stats.json").read_text())
    rows = rows_of(exports["lerobot"])
    assert np.asarray(stats["observation.images.rgb"]["mean"]).shape == (3, 1, 1)
    assert stats["action"]["mean"] == [pytest.approx(rows["action"].mean())]
    assert stats["action"]["std"] == [pytest.approx(rows["action"].std(ddof=0))]
    poses = np.stack(rows["observation.state"])
    assert stats["observation.state"]["min"] == poses.min(axis=0).tolist()
    assert stats["observation.state"]["count"] == [len(rows)]


def test_lerobot_reads_it(data: Path, exports: dict[str, Path]) -> None:
    """LeRobot's own reader."""
    lerobot = pytest.importorskip(
        "lerobot.datasets.lerobot_dataset",
        reason="LeRobot asks for its own releases of torch and torchvision, 3 GB; `pip install lerobot` runs this test",
    )
    dataset = lerobot.LeRobotDataset("arramon/tiny", root=exports["lerobot"])
    episodes = expected_episodes(data)
    assert dataset.num_episodes == len(episodes)
    for number in (0, len(episodes) - 1):
        for step, expected in enumerate(expected_observations(data, *episodes[number])):
            item = dataset[number * STEPS + step]
            picture = (item["observation.images.rgb"].numpy().transpose(1, 2, 0) * 255).round().astype(np.uint8)
            assert (picture == expected.rgb).all()
            assert (item["observation.depth"].numpy() == expected.depth).all()
            assert item["task"] == expected.instruction
            assert int(item["action"]) == tiny.ACTIONS[step]
