"""Recordings of runs: contents, no effect on the run, and disk errors."""

import json
import subprocess
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import simplejpeg
from PIL import Image

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.agent import Episode, Observation
from arramon_client.cli import main
from arramon_client.recording import recorder as recording_module
from arramon_client.recording.files import depth_png, folder_name
from arramon_client.recording.recorder import Recording
from arramon_client.recording.trace import FROM_ACTIONS, FROM_POSE, Trace
from arramon_client.world import Action
from arramon_server.sim import geometry
from arramon_server.sim.rules import Limits, Phase, State, step
from tests import tiny
from tests.client.fake import RUN, Servicer, World, serving

AGENT = """
import os, signal
class Agent:
    def begin(self, episode): pass
    def act(self, observations): return [(int(o.episode_id[1:]) + o.step) % 4 for o in observations]
class Failing(Agent):
    def act(self, observations):
        if observations[0].step == 2: raise ValueError("no weights")
        return super().act(observations)
class Interrupting(Agent):
    def act(self, observations):
        if observations[0].step == 2: os.kill(os.getpid(), signal.SIGINT)
        return super().act(observations)
"""

BY_RULE = {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}


@pytest.fixture
def address(world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "recorded_agents.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    with serving(Servicer(world)) as served:
        yield served
    sys.modules.pop("recorded_agents", None)


def command(address: str, *more: str) -> list[str]:
    return ["--agent", "recorded_agents", "--lang", "en", "--server", address, *more]


def steps_of(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "steps.jsonl").read_text().splitlines()]


def test_a_recording_holds_what_the_agent_saw_and_did(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(address, "--record", "rec", "--parallel", "2")) == 0
    assert world.actions == BY_RULE
    assert f"recording: rec/{RUN}/index.html" in capsys.readouterr().out
    assert sorted(path.name for path in Path(f"rec/{RUN}").iterdir()) == ["e0", "e1", "e2", "e3", "index.html"]
    for episode_id, actions in BY_RULE.items():
        folder = Path(f"rec/{RUN}") / episode_id
        steps = steps_of(folder)
        assert [step["action"] for step in steps] == actions
        assert [step["instruction"] for step in steps] == [f"go {number}" for number in range(5)]
        about = json.loads((folder / "episode.json").read_text())
        assert (about["cause"], about["steps"], about["poses"]) == ("AGENT_FINISHED", 5, FROM_ACTIONS)
        rgb = simplejpeg.decode_jpeg((folder / steps[4]["rgb"]).read_bytes())
        assert rgb.shape == (2, 3, 3)
        depth = np.asarray(Image.open(folder / steps[4]["depth"]))
        assert depth.tolist() == [[1000, 65535]]
        assert (folder / "index.html").read_text().startswith("<!DOCTYPE html>")


def test_without_record_nothing_is_written(world: World, address: str) -> None:
    assert main(command(address)) == 0
    assert world.actions == BY_RULE
    assert sorted(path.name for path in Path().iterdir() if path.is_dir() and path.name != "__pycache__") == [
        "arramon-results"
    ]


def test_the_step_of_a_failure_is_recorded(world: World, address: str) -> None:
    assert main([*command(address, "--record", "rec"), "--agent", "recorded_agents:Failing"]) != 0
    steps = steps_of(Path(f"rec/{RUN}/e0"))
    assert [step["action"] for step in steps] == [0, 1, None]
    assert "rgb" in steps[2]


@pytest.mark.usefixtures("interruptible")
def test_an_interrupted_run_has_pages_of_the_played_steps(world: World, address: str) -> None:
    assert main([*command(address, "--record", "rec"), "--agent", "recorded_agents:Interrupting"]) == 130
    assert [step["action"] for step in steps_of(Path(f"rec/{RUN}/e1"))][:2] == BY_RULE["e1"][:2]
    assert json.loads(Path(f"rec/{RUN}/e1/episode.json").read_text())["cause"] == ""
    assert "not ended when the recording stopped" in Path(f"rec/{RUN}/e1/index.html").read_text()
    assert "not ended when the recording stopped" in Path(f"rec/{RUN}/index.html").read_text()


def test_a_resumed_run_is_recorded_with_the_original_actions(world: World, address: str) -> None:
    """The history of an open episode is recorded too, with what was taken then, not with what would be taken now."""
    world.create(pb.CreateRunRequest(agent="recorded_agents", split="val_seen", language="en"))
    world.players, world.actions = {"e0": "another"}, {"e0": [3, 3]}
    assert main([*command(address, "--record", "rec"), "--resume", RUN]) == 0
    assert [step["action"] for step in steps_of(Path(f"rec/{RUN}/e0"))] == [3, 3, 2, 3, 0]


def test_an_unwritable_folder_is_reported_before_a_run_is_created(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(address, "--record", "recorded_agents.py")) == 1
    assert "error: the recording cannot be written to recorded_agents.py" in capsys.readouterr().err
    assert world.run.run_id == ""


def test_a_recording_that_fails_does_not_affect_the_run(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("rec").mkdir()
    Path(f"rec/{RUN}").write_text("in the way")
    assert main(command(address, "--record", "rec")) == 1
    shown = capsys.readouterr()
    assert shown.err.count(f"warning: the recording in rec/{RUN} is incomplete: ") == 1
    assert f"error: the recording in rec/{RUN} is incomplete: " in shown.err
    assert "Traceback" not in shown.err
    assert "nDTW" in shown.out
    assert world.actions == BY_RULE
    assert json.loads(Path(f"arramon-results/{RUN}.json").read_text())["actions"]["e1"] == "12301"


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), resource.RLIM_INFINITY))
from arramon_client.cli import main
sys.exit(main(sys.argv[2:]))
"""


def test_a_full_disk_does_not_affect_the_run(world: World, address: str) -> None:
    """The operating system lets no file grow beyond what the results need, which is less than a page does."""
    assert main(command(address, "--record", "rec")) == 0
    results, page = Path(f"arramon-results/{RUN}.json"), Path(f"rec/{RUN}/e0/index.html")
    kept, limit = json.loads(results.read_text()), (results.stat().st_size + page.stat().st_size) // 2
    assert results.stat().st_size < limit < page.stat().st_size
    results.unlink()
    for known in (world.actions, world.causes, world.players):
        known.clear()
    arguments = [str(limit), *command(address, "--record", "again")]
    done = subprocess.run([sys.executable, "-c", LIMITED, *arguments], capture_output=True, text=True, timeout=120)
    assert done.returncode == 1, done.stderr
    assert f"error: the recording in again/{RUN} is incomplete: " in done.stderr
    assert "File too large" in done.stderr
    assert "Traceback" not in done.stderr
    assert world.actions == BY_RULE
    assert json.loads(results.read_text())["actions"] == kept["actions"]
    assert not list(Path("again").rglob("*.part"))
    assert len(steps_of(Path(f"again/{RUN}/e0"))) == 5


def test_a_slow_disk_leaves_out_images_but_no_actions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_module, "MAX_QUEUED_BYTES", 17)  # Less than one picture takes.
    with Recording(tmp_path, pb.Run(run_id="r", language="en"), lambda _: None) as recording:
        recording.begin(Episode("a", "en", "tiny"))
        recording.step(observation(0), 1)
        recording.end("a", types_pb2.CAUSE_STEP_LIMIT)
    about = json.loads((tmp_path / "r/a/episode.json").read_text())
    assert (about["steps"], about["pictures_left_out"], about["cause"]) == (1, 1, "STEP_LIMIT")
    assert "rgb" not in steps_of(tmp_path / "r/a")[0]
    assert "1 steps have no pictures" in (tmp_path / "r/a/index.html").read_text()


def observation(step: int, **fields: Any) -> Observation:
    return Observation(
        **{
            "episode_id": "a", "turn": 1, "phase": "navigation", "step": step, "instruction": "go", "phase_step": step,
            "steps_left": 9, "rgb": np.zeros((2, 3, 3), np.uint8), **fields,
        }
    )  # fmt: skip


@pytest.mark.parametrize(
    "episode_id", ["../../x", "..", ".", "", "/etc/passwd", "a/b", "a\\b", "a\0b", "लाल", "x" * 300, "CON:", ".hidden"]
)
def test_episode_ids_never_escape_the_recording_folder(tmp_path: Path, episode_id: str) -> None:
    name = folder_name(episode_id)
    assert (tmp_path / name).resolve().parent == tmp_path.resolve()
    assert len(name.encode()) < 100
    assert name != folder_name(episode_id + "_")
    (tmp_path / name).mkdir()


def test_plain_episode_ids_name_their_folders() -> None:
    assert [folder_name(name) for name in ("8900", "val-unseen_12.a")] == ["8900", "val-unseen_12.a"]


def test_depth_is_lossless() -> None:
    thousandths = np.random.default_rng(0).integers(0, 65536, (37, 53)).astype(np.uint16)
    read = np.asarray(Image.open(BytesIO(depth_png(thousandths.astype(np.float32) * np.float32(0.001)))))
    assert (read == thousandths).all()


class _Free:
    """Ground without obstacles."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        return True


def test_dead_reckoning_equals_the_rules_on_free_ground() -> None:
    layout = tiny.episode("a").layout
    trace = Trace()
    moves = np.random.default_rng(1).integers(0, 3, 200)
    for phase in Phase:
        state = State(pose=geometry.Pose(0.0, 0.0, 0.0), room=(), phase=phase)
        for number, move in enumerate(map(int, moves)):
            seen = observation(number, phase=phase.value, phase_step=number)
            here = state.pose if phase is Phase.NAVIGATION else geometry.Pose(*state.square, state.room_heading)
            assert trace.at(seen) == pytest.approx((here.x, here.z, here.heading), abs=1e-9)
            state, _ = step(state, Action(move), layout, _Free(), Limits(1000))
            trace.move(seen, move)
    assert trace.source == FROM_ACTIONS


def test_an_observed_pose_takes_precedence() -> None:
    trace = Trace()
    trace.move(observation(0), 0)
    assert trace.at(observation(1, pose=(5.0, 6.0, 30.0))) == (5.0, 6.0, 30.0)
    assert trace.source == FROM_POSE
