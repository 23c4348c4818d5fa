"""Frame rate of another project's environment, started by `cameras.py` and `environments.py` in its own interpreter.

    python -m benchmarks.simulation.peers vizdoom|miniworld|babyai [--seconds 2]

A frame is one step of the environment with its whole observation: ViZDoom 320x240 RGB and depth, MiniWorld 224x224 RGB,
MiniGrid's BabyAI 7x7 symbols and a mission's text.
Prints the frames per second; exits with status 3 if the environment is not installed. The interpreter of the other
project has none of this one's packages: this file imports nothing but what comes with Python.
"""

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

NOT_HERE = 3


def vizdoom() -> Callable[[], Any]:
    """Return a function that takes one step in ViZDoom's maze of rooms."""
    vzd = import_module("vizdoom")
    game = vzd.DoomGame()
    game.load_config(str(Path(vzd.scenarios_path) / "my_way_home.cfg"))
    game.set_screen_resolution(vzd.ScreenResolution.RES_320X240)
    game.set_screen_format(vzd.ScreenFormat.RGB24)
    game.set_depth_buffer_enabled(True)
    game.set_window_visible(False)
    game.set_sound_enabled(False)
    game.set_mode(vzd.Mode.PLAYER)
    game.set_seed(1)
    game.init()
    buttons = len(game.get_available_buttons())
    actions = itertools.cycle([[int(i == j % 3) for i in range(buttons)] for j in (0, 2, 2, 1, 2, 2)])

    def step() -> Any:
        if game.is_episode_finished():
            game.new_episode()
        game.make_action(next(actions))
        state = game.get_state()
        return None if state is None else (state.screen_buffer, state.depth_buffer)

    return step


def miniworld() -> Callable[[], Any]:
    """Return a function that takes one step in MiniWorld's four rooms."""
    import_module("pyglet").options["headless"] = "DISPLAY" not in os.environ
    import_module("miniworld")  # registers its environments
    environment = import_module("gymnasium").make("MiniWorld-FourRooms-v0", obs_width=224, obs_height=224)
    environment.reset(seed=1)
    actions = itertools.cycle([2, 2, 0, 2, 1, 2])

    def step() -> Any:
        observation, _, ended, cut, _ = environment.step(next(actions))
        assert observation.shape == (224, 224, 3)
        if ended or cut:
            environment.reset()
        return observation

    return step


def babyai() -> Callable[[], Any]:
    """Return a function that takes one step in MiniGrid's BabyAI, which draws nothing."""
    import_module("minigrid")  # registers its environments
    environment = import_module("gymnasium").make("BabyAI-GoToLocal-v0")
    environment.reset(seed=1)
    actions = itertools.cycle([2, 2, 0, 2, 1, 2])

    def step() -> Any:
        observation, _, ended, cut, _ = environment.step(next(actions))
        assert observation["mission"]
        if ended or cut:
            environment.reset()
        return observation

    return step


def frames_per_second(python: str, peer: str, seconds: float) -> float | None:
    """Measure another environment in its own interpreter; None if it is not installed there.

    Raises:
        SystemExit: if it cannot be measured for another reason, such as a missing display.
    """
    command = [python, str(Path(__file__).absolute()), peer, "--seconds", str(seconds)]
    with tempfile.TemporaryDirectory() as folder:  # ViZDoom writes a file to the working directory.
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode == NOT_HERE:
        return None
    if done.returncode:
        sys.exit(f"{peer} cannot be measured with {python}:\n{done.stderr.strip()}")
    return float(done.stdout.split()[-1])


def main() -> int:
    """Print the frames per second."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peer", choices=("vizdoom", "miniworld", "babyai"), help="environment")
    parser.add_argument("--seconds", type=float, default=2.0, help="duration (default: %(default)s)")
    arguments = parser.parse_args()
    try:
        step = {"vizdoom": vizdoom, "miniworld": miniworld, "babyai": babyai}[arguments.peer]()
    except ImportError as error:
        print(error, file=sys.stderr)
        return NOT_HERE
    for _ in range(50):
        step()
    frames, start = 0, time.perf_counter()
    while time.perf_counter() - start < arguments.seconds:
        step()
        frames += 1
    print(frames / (time.perf_counter() - start))
    return 0


if __name__ == "__main__":
    sys.exit(main())
