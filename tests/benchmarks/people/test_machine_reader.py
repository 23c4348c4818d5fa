"""A machine reader on a real server: keys count once, presses stop at events, and nothing printed tells a score."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchmarks.people.page_state import landing_lines
from tests.benchmarks.command import printed, run
from tests.web.play.page_client import PageServer

READER = "benchmarks.people.machine_reader"

PRESSES: tuple[tuple[str, list[str], str], ...] = (
    ("FFPF", ["1. F: You moved one step.", "2. F: You moved one step.", "3. P: You picked up: striped red mug"], "F"),
    ("FPR", ["1. F: You moved one step.", "2. P: You placed the object."], "R"),
    ("RRRFFP", [*(f"{number}. R: You turned right." for number in (1, 2, 3)), "4. F: You moved one step."], ""),
)
"""Keys of the ground truth, with some too many; the first lines that are printed; the keys that are not pressed."""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    server = PageServer(tmp_path_factory.mktemp("data"), "--play-landing-diagram", "--step-seconds", "0")
    yield server
    assert server.stop() == 0


@contextmanager
def serving(site: str, folder: Path) -> Iterator["subprocess.Popen[str]"]:
    options = ["--site", site, "--folder", str(folder), "--name", "one", "--split", "tiny", "--episodes", "2"]
    process = subprocess.Popen([sys.executable, "-m", READER, "serve", *options], stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.terminate()
        process.communicate()


def press(folder: Path, keys: str) -> list[str]:
    return printed(READER, "press", folder, keys)


def test_two_episodes(server: PageServer, tmp_path: Path) -> None:
    said: list[str] = []
    with serving(server.site, tmp_path):
        said += printed(READER, "look", tmp_path)
        assert "Instruction: Go on to the striped red mug." in said
        lines = press(tmp_path, "FFPF")
        assert "Instruction: Put it two steps ahead." in lines
        assert "You carry: striped red mug. Steps left in this part: 150" in lines
        assert lines[-5:-1] == ["    . . . . .", "    . . . . .", "    . . X . .", "    . . ^ . ."]
        _check(lines, *PRESSES[0])
        assert Path(lines[-1].removeprefix("Frame: ")).read_bytes()[:2] == b"\xff\xd8"
        assert (tmp_path / "sheets" / "episode001-step0003.png").read_bytes()[:4] == b"\x89PNG"
        again = run(READER, "serve", "--site", server.site, "--folder", tmp_path, "--name", "one")
        assert (again.returncode, "another process serves" in again.stderr) == (1, True)
    with serving(server.site, tmp_path) as reader:
        for keys, expected, left in PRESSES[1:]:
            lines = press(tmp_path, keys)
            _check(lines, keys, expected, left)
            said += lines
        lines = press(tmp_path, "FPF")
        assert lines[1:3] == [
            "2. P: The episode has ended: you finished it. The next episode begins.",
            "Not pressed: F",
        ]
        said += lines
        for keys in ("FFP", "FP", "RRRFFP", "FP"):
            said += press(tmp_path, keys)
        assert said[-1] == "The run has ended. Episodes: 2."
        reader.wait(timeout=60)
    assert printed(READER, "look", tmp_path) == ["The run has ended. Episodes: 2."]
    assert not re.search(r"nDTW|CTC|PTC|rPOD|score|0\.\d|1\.0", "\n".join(said))
    (row,) = [line for line in printed(READER, "scores", server.address) if line.startswith("machine reader one")]
    # Every key counted once: one more, or one less, and the second object would be missed.
    assert row.count(" 1.000 (") == 4


def _check(lines: list[str], keys: str, expected: list[str], left: str) -> None:
    assert lines[: len(expected)] == expected
    assert [line for line in lines if line.startswith("Not pressed")] == ([f"Not pressed: {left}"] if left else [])
    assert sum(bool(re.match(r"\d\. ", line)) for line in lines) == len(keys) - len(left)


def test_nowhere_to_place() -> None:
    first, *grid = landing_lines({"cell": [0, 3], "heading": 30, "landing": None})
    assert "nowhere: face a wall straight" in first
    assert grid == ["    o . . . .", "    . . . . .", "    . . . . .", "    . . . . ."]


@pytest.mark.parametrize("keys", ["", "FX", "FFFFFFFFF"])
def test_wrong_keys(tmp_path: Path, keys: str) -> None:
    done = run(READER, "press", tmp_path, keys)
    assert done.returncode == 2
    assert "is not 1 to 8 of the letters F, L, R, P" in done.stderr
