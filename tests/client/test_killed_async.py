"""An agent that waits, killed at moments all over its calls: no call is paid twice, except those in flight."""

import random
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.client.fake import RUN, Recorder, Servicer, World, serving
from tests.moments import spread_moments

PARALLEL = 3
AGENT = """
import asyncio
class Agent:
    sensors = ()
    def begin(self, episode): pass
    async def act(self, seen):
        self.log("act", seen)
        await asyncio.sleep(0.005)
        return (int(seen.episode_id[1:]) + seen.step) % 4
    def replay(self, seen, action):
        assert action == seen.taken
        self.log("replay", seen)
    def log(self, method, seen):
        with open("calls", "a") as calls:
            calls.write(f"{method} {seen.episode_id} {seen.step}\\n")
"""


class Client:
    """Plays the run again and again, and is killed."""

    def __init__(self, address: str, folder: Path) -> None:
        (folder / "paid.py").write_text(AGENT)
        self._folder, self._calls = folder, folder / "calls"
        self._command: list[Any] = [
            sys.executable, "-m", "arramon_client", "--agent", "./paid.py", "--lang", "en", "--server", address,
            "--parallel", str(PARALLEL),
        ]  # fmt: skip

    def calls(self) -> list[tuple[str, str, int]]:
        """Return the calls of the agent: method, episode, step."""
        lines = self._calls.read_text().splitlines() if self._calls.exists() else []
        return [(method, episode_id, int(step)) for method, episode_id, step in map(str.split, lines)]

    def play_and_kill(self, *options: str, calls: int, seconds: float) -> None:
        """Kill the client some time after a number of new calls, unless the run is over before."""
        before = len(self.calls())
        with subprocess.Popen(
            [*self._command, *options], cwd=self._folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as client:
            while len(self.calls()) < before + calls and client.poll() is None:
                time.sleep(0.001)
            time.sleep(seconds)
            client.kill()

    def play_to_the_end(self) -> None:
        done = subprocess.run(
            [*self._command, "--resume", RUN], cwd=self._folder, check=False, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("kills", [2, pytest.param(16, marks=pytest.mark.slow)])
def test_recorded_steps_are_never_asked_again(tmp_path: Path, kills: int) -> None:
    world, chance = World(episodes=6, steps=4 * kills), random.Random(kills)
    recorded: list[dict[str, int]] = []  # By life of the client: steps of each episode that were recorded before.
    calls: list[list[tuple[str, str, int]]] = []  # By life: the agent's calls.

    def note_life(play: Callable[[], None]) -> None:
        before = len(client.calls())
        recorded.append({episode_id: len(taken) for episode_id, taken in world.actions.items()})
        play()
        calls.append(client.calls()[before:])

    with serving(Servicer(world)) as address:
        client = Client(address, tmp_path)
        for kill, moment in enumerate(spread_moments(kills, 0.02, seed=kills)):
            options, least = (("--resume", RUN), chance.randrange(60)) if kill else ((), 1)
            note_life(partial(client.play_and_kill, *options, calls=least, seconds=moment))
        note_life(client.play_to_the_end)
    assert world.actions == {
        episode_id: [Recorder.rule(episode_id, step) for step in range(world.steps)] for episode_id in world.order
    }
    for before, made in zip(recorded, calls, strict=True):
        assert len(made) == len(set(made))
        assert all(step >= before.get(episode_id, 0) for method, episode_id, step in made if method == "act")
    paid = Counter(call for made in calls for call in made if call[0] == "act")
    assert len(paid) == len(world.order) * world.steps
    assert paid.total() - len(paid) <= kills * PARALLEL
    assert any(call[0] == "replay" for made in calls for call in made)
