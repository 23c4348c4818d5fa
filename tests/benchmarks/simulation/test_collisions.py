"""The comparison of pybullet with plane geometry: its moves, and resuming from a log."""

import json
import math
from itertools import islice
from pathlib import Path
from random import Random

import pytest

from arramon_client.world import AGENT_RADIUS, STEP
from arramon_server.sim.city import city_scene
from arramon_server.sim.footprints import TOUCHING, Footprint, Footprints
from tests.dataset.plans.sections import section_of
from tests.physics import needs_pybullet

pytestmark = needs_pybullet


def test_moves_almost_touch_what_is_nearest() -> None:
    from benchmarks.simulation.collisions import steps_that_almost_touch

    scene = city_scene(section_of("1"))
    plane = Footprints(scene)
    solid = [Footprint.of(body) for body in scene.bodies if body.collider is not None]
    found = []
    for start, end in islice(steps_that_almost_touch(scene, plane, Random(1)), 200):
        assert math.dist(start, end) == pytest.approx(STEP)
        found.append(min(footprint.distance(start, end) for footprint in solid) - AGENT_RADIUS)
    assert max(map(abs, found)) <= TOUCHING
    assert min(found) < -TOUCHING / 2 < TOUCHING / 2 < max(found)


def test_a_comparison_goes_on_where_it_was_ended(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from benchmarks.simulation.collisions import main

    arguments = ["--moves", "900", "--timed", "50", "--log", str(tmp_path / "log"), "--json", str(tmp_path / "json")]
    assert main([*arguments, "--minutes", "0"]) == 0
    assert "chunks are left" in capsys.readouterr().out
    assert main(arguments) == 0
    assert "chunks are left" not in capsys.readouterr().out
    total = json.loads((tmp_path / "json").read_text())["rows"]["total"]
    assert (total["moves"], total["differ"]) == (900, 0)
    before = (tmp_path / "log").read_text()
    assert main(arguments) == 0
    assert (tmp_path / "log").read_text() == before
    assert json.loads((tmp_path / "json").read_text())["rows"]["total"] == total
