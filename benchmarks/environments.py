"""Steps per second of the environments in process, beside the bare camera with rules, and other environments.

    python benchmarks/environments.py [--data DIR] [--seconds 3] [--rounds 5] [--peers PYTHON] [--json FILE]

The rows alternate, round by round, so that changes of the machine's speed affect all of them; the table shows medians.
"Bare" is what every step needs: rules and frame of 16 episodes in turn, without observations. In two processes it is
drawn by two that know nothing of each other, half of the episodes each: what this machine gives two processes at all.
`--peers` names an interpreter with the packages `miniworld` and `minigrid`, if it is not this one. The table's CPU time
is that of this process (for the bare camera in two, of each): it says what a step costs where other programs take the
cores, too.
"""

import argparse
import json
import multiprocessing
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from common import data_or_sample

from arramon_client.environments.two_agents import raw_env
from server.episodes.splits import Split, read_splits
from server.runs.play.session import Session
from server.runs.play.worlds import Worlds
from server.sim.rules import Action, Limits

HERE = Path(__file__).parent
COUNT = 16
"""Episodes of a vector environment, and of the bare camera."""

PEERS = {"miniworld": "MiniWorld, 224x224, RGB", "babyai": "MiniGrid's BabyAI, no images"}

Measured = tuple[float, float]
"""Steps per second, and milliseconds of this process's CPU time per step; 0 where it is not known."""


@dataclass
class Row:
    """A row of the table: its measurement, and the results by round."""

    name: str
    measure: Callable[[float], Measured | None]
    results: list[Measured] = field(default_factory=list)

    @property
    def rate(self) -> float:
        """Median of the steps per second."""
        return statistics.median(rate for rate, _ in self.results)

    @property
    def cost(self) -> float:
        """Median of the CPU time per step, in milliseconds."""
        return statistics.median(cost for _, cost in self.results)


def timed(step: Callable[[int], int], seconds: float) -> Measured:
    """Call a function with 0, 1, ... for some time; it returns the number of steps that it took."""
    for number in range(20):
        step(number)
    steps = number = 0
    started, worked = time.perf_counter(), time.process_time()
    while time.perf_counter() - started < seconds:
        steps += step(number)
        number += 1
    return steps / (time.perf_counter() - started), 1e3 * (time.process_time() - worked) / steps


def bare(split: Split, size: int, share: slice = slice(None)) -> Callable[[float], Measured]:
    """Return the measurement of rules and frames alone, of all episodes or a share of them."""

    worlds, limits = Worlds({split.name: split}), Limits()
    episodes = list(islice(cycle(split.in_playing_order(min(split.languages))), COUNT))[share]
    sessions = [Session(e, worlds.ground(split.name, e), limits) for e in episodes]

    def step(number: int) -> int:
        for here, session in enumerate(sessions):
            if session.state.finished:
                ground = worlds.ground(split.name, session.episode)
                session = sessions[here] = Session(session.episode, ground, limits)
            session.apply(Action((number * COUNT * 7 + here * 24) % 3))
            worlds.render(split.name, session.episode, session.state, size)
        return len(sessions)

    return lambda seconds: timed(step, seconds)


def bare_in_processes(split: Split, size: int, count: int) -> Callable[[float], Measured]:
    """Return the measurement of rules and frames alone in processes that draw at the same time; their rates are added.

    They are forked after everything is compiled, and begin together once each has drawn all its episodes.
    """
    context = multiprocessing.get_context("fork")

    def draw(share: slice, seconds: float, ready: Any, pipe: Any) -> None:
        measure = bare(split, size, share)
        measure(0.1)
        ready.wait()
        pipe.send(measure(seconds))

    def measure(seconds: float) -> Measured:
        ready, running = context.Barrier(count), []
        for number in range(count):
            pipe, other = context.Pipe(duplex=False)
            process = context.Process(target=draw, args=(slice(number, None, count), seconds, ready, other))
            process.start()
            running.append((process, pipe))
        results: list[Measured] = [pipe.recv() for _, pipe in running]
        for process, _ in running:
            process.join()
        return sum(rate for rate, _ in results), statistics.mean(cost for _, cost in results)

    return measure


def single(data: Path, split: Split, size: int) -> Callable[[float], Measured]:
    """Return the measurement of one episode at a time."""

    def measure(seconds: float) -> Measured:
        env: Any = gymnasium.make("arramon/ArraMon-v0", data=data, split=split.name, image_size=size)
        env.reset(seed=0)

        def step(number: int) -> int:
            if env.step(number * 7 % 3)[2]:
                env.reset()
            return 1

        return timed(step, seconds)

    return measure


def vector(data: Path, split: Split, size: int, processes: int) -> Callable[[float], Measured]:
    """Return the measurement of many episodes at once, the same as those of the bare camera."""
    chosen = split.in_playing_order(min(split.languages))
    episodes = [episode.episode_id for episode in islice(cycle(chosen), COUNT)]

    def measure(seconds: float) -> Measured:
        env: Any = gymnasium.make_vec(
            "arramon/ArraMon-v0", COUNT, processes=processes, data=data, split=split.name, image_size=size
        )
        env.reset(options={"episode": episodes})
        offsets = np.arange(COUNT) * 24

        def step(number: int) -> int:
            env.step((number * COUNT * 7 + offsets) % 3)
            return COUNT

        measured = timed(step, seconds)
        env.close()
        return measured

    return measure


def two_agents(data: Path, split: Split, size: int) -> Callable[[float], Measured]:
    """Return the measurement of PettingZoo's interface."""

    def measure(seconds: float) -> Measured:
        env = raw_env(data=data, split=split.name, image_size=size)
        env.reset(seed=0)

        def step(number: int) -> int:
            if env.last()[2]:
                env.reset()
            env.step(number * 7 % 3)
            return 1

        return timed(step, seconds)

    return measure


def peer(python: str, name: str) -> Callable[[float], Measured | None]:
    """Return the measurement of another environment; None if it is not installed, or finds no display."""

    def measure(seconds: float) -> Measured | None:
        command = [python, str(HERE.absolute() / "camera_peers.py"), name, "--seconds", str(seconds)]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        return (float(done.stdout.split()[-1]), 0.0) if done.returncode == 0 else None

    return measure


def rows_of(data: Path, split: Split, peers: str) -> list[Row]:
    """Return the rows of the table."""
    return [
        Row("bare camera with rules, 224", bare(split, 224)),
        Row("bare camera, two processes, 224", bare_in_processes(split, 224, 2)),
        Row("one episode, 224", single(data, split, 224)),
        Row("16, one process, 224", vector(data, split, 224, 1)),
        Row("16, two processes, 224", vector(data, split, 224, 2)),
        Row("two agents by turns, 224", two_agents(data, split, 224)),
        Row("bare camera with rules, 64", bare(split, 64)),
        Row("bare camera, two processes, 64", bare_in_processes(split, 64, 2)),
        Row("16, one process, 64", vector(data, split, 64, 1)),
        Row("16, two processes, 64", vector(data, split, 64, 2)),
        *(Row(title, peer(peers, name)) for name, title in PEERS.items()),
    ]


def table(rows: Sequence[Row]) -> str:
    """Return the table, with the ratios that matter below it."""
    lines = [f"{'RGB + depth':34}{'steps/s':>10}{'of bare':>9}{'CPU ms a step':>15}"]
    base = rows[0].rate
    for row in rows:
        if not row.results:
            lines.append(f"{row.name:34}{'not here':>10}")
            continue
        cost = f"{row.cost:15.3f}" if row.cost else f"{'':15}"
        lines.append(f"{row.name:34}{row.rate:10.0f}{row.rate / base:9.2f}{cost}")
    by_name = {row.name: row for row in rows}
    one, two = by_name["16, one process, 224"], by_name["16, two processes, 224"]
    small, drawn_by_two = by_name["16, one process, 64"], by_name["bare camera, two processes, 224"]
    single_row = by_name["one episode, 224"]
    lines.append(
        f"of the bare camera, one episode: {paired(single_row, rows[0]):.2f}, by CPU time "
        f"{rows[0].cost / single_row.cost:.2f}; 16 in one process: {paired(one, rows[0]):.2f}, by CPU time "
        f"{rows[0].cost / one.cost:.2f}\n"
        f"two processes of one: {paired(two, one):.2f}, of the bare camera {paired(drawn_by_two, rows[0]):.2f}; "
        f"64x64 of 224: {paired(small, one):.2f}"
    )
    return "\n".join(lines)


def paired(row: Row, other: Row) -> float:
    """Return the median, over the rounds, of one row's rate by another's in the same round."""
    return statistics.median(one[0] / two[0] for one, two in zip(row.results, other.results, strict=True))


def main() -> int:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--seconds", type=float, default=3.0, help="duration of each measurement")
    parser.add_argument("--rounds", type=int, default=5, help="number of rounds")
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has MiniWorld and MiniGrid")
    parser.add_argument("--json", type=Path, help="output file for the results")
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        rows = rows_of(data, split, options.peers)
        for _ in range(options.rounds):
            for row in rows:
                measured = row.measure(options.seconds)
                row.results += [] if measured is None else [measured]
    print(f"split {split.name}, {len(split.episodes)} episodes\n{table(rows)}")
    if options.json:
        options.json.write_text(json.dumps({row.name: row.results for row in rows}, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
