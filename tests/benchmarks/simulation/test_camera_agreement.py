"""The camera comparison on a few poses: sample sections, own sections, and the room."""

import json
from pathlib import Path

from tests.benchmarks.command import printed
from tests.physics import needs_pybullet


@needs_pybullet
def test_cameras_agree_in_sample_and_own_sections_and_the_room(tmp_path: Path) -> None:
    arguments = "--poses", 50, "--own", 3, 7, "--json", tmp_path / "rows.json", "--pictures", tmp_path
    assert printed("benchmarks.simulation.camera_agreement", *arguments)[-1].startswith("all")
    rows = json.loads((tmp_path / "rows.json").read_text())["places"]
    assert [row["place"] for row in rows] == ["sample 1", "sample 2", "own section 3", "own section 7", "room"]
    for row in rows:
        assert row["poses"] == 10
        assert row["depth"] > 0.9995 * row["pixels"]
        assert row["segmentation"] > 0.9995 * row["pixels"]
        assert row["beyond_edges"] < 50
        assert row["unexplained"] <= 1
        assert row["colour"] < 10 * row["poses"]
        assert row["colour_without_mipmaps"] < 0.5 * row["poses"]
