"""The server's profile: stages of stacks, and a recording if py-spy is installed."""

import shutil
from pathlib import Path

import pytest

from benchmarks.serving.flames import REST, STAGES, profiler_prefix, stage_of, stage_shares
from tests.benchmarks.command import numbers, printed

OUTER = "main (arramon_server/cli.py:55);Engine.run (arramon_server/runs/play/engine.py:170)"

STACKS = {
    f"{OUTER};Delivery.deliver (a.py:1);RasterCamera.render (b.py:2)": "drawing",
    f"{OUTER};Assignment.open (a.py:1);Worlds.load (a.py:9)": "worlds, built when episodes are opened",
    f"{OUTER};EpisodeWorld.render (a.py:1);view (b.py:2)": "view: poses of the objects",
    f"{OUTER};MeteredJournal.commit (a.py:1);Steps.commit (b.py:2)": "journal: commit",
    f"{OUTER};WorkerRegistry.beat (a.py:1)": "journal: the rest",
    f"{OUTER};SharedMemoryEncoder.encode (a.py:1)": "messages: images",
    f"{OUTER};EventSender.send (a.py:1);_field (b.py:2)": "messages: the rest",
    f"{OUTER};EpisodeSession.apply (a.py:1);step (b.py:2)": "rules and scores",
    f"{OUTER};Upkeep.sweep (a.py:1)": "the engine itself",
    "main (arramon_server/cli.py:55);Handle._run (asyncio/events.py:80)": REST,
    "main (arramon_server/cli.py:55);EpollSelector.select (selectors.py:468)": "",
    "Thread.run (threading.py:982);_worker (concurrent/futures/thread.py:83)": "",
    "_worker (concurrent/futures/thread.py:83);EpisodeWorld.render (a.py:1);RasterCamera.render (b.py:2)": "drawing",
}


@pytest.mark.parametrize(("stack", "stage"), STACKS.items())
def test_stage_of_a_stack(stack: str, stage: str) -> None:
    assert stage_of(stack) == stage


def test_marks_are_the_names_of_code() -> None:
    """As a profiler gives them: a function's with the class that defines it, a class's as the beginning of these."""
    found = {mark for codes in STAGES.values() for mark in map(profiler_prefix, codes)}
    assert {"RasterCamera.render (", "Steps.commit (", "Journal.", "Engine."} <= found
    assert "object." not in found  # Every method would belong to the journal.


def test_shares_leave_out_what_waits() -> None:
    busy, *_ = STACKS
    waiting = next(stack for stack, stage in STACKS.items() if not stage)
    found = stage_shares(f"{busy} 3\n{OUTER} 1\n{waiting} 96\n")
    assert found["drawing"] == 0.75
    assert sum(found.values()) == 1.0
    assert list(found) == [*STAGES, REST]


def test_a_recording(many: Path, tmp_path: Path) -> None:
    if shutil.which("py-spy") is None:
        pytest.skip("py-spy is not installed: pip install py-spy")
    lines = printed("benchmarks.serving.flames", "--data", many, "--seconds", 1, "--output", tmp_path)
    assert lines[0].startswith("16 episodes, shared: ")
    found = {stage: numbers(lines, stage)[0] for stage in (*STAGES, REST)}
    assert sum(found.values()) == pytest.approx(100.0, abs=1.0)
    assert "Engine.run" in (tmp_path / "server.txt").read_text()
    assert (tmp_path / "server.svg").read_text().rstrip().endswith("</svg>")
