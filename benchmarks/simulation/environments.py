"""Steps per second of the environments in process, beside the bare camera with rules, and other environments.

    python -m benchmarks.simulation.environments [--data DIR] [--steps 300] [--rounds 5] [--peers PYTHON] [--json FILE]

The rows alternate, round by round, so that changes of the machine's speed affect all of them; the table shows medians.
All rows but those of other environments draw the same frames: the first steps of the same walk through the same 16
episodes, as how long a frame takes depends on what is seen. "Bare" is what every step needs: rules and frame of the
episodes by turns, without observations; "one after another" is the same in the order of a single environment. In two
processes, two independent processes render half of the episodes each, which shows how far two processes scale on this
machine.
`--peers` names an interpreter with the packages `miniworld` and `minigrid`, if it is not this one. The table's CPU time
is that of this process (for the bare camera in two, of each): it says what a step costs where other programs take the
cores, too.
"""

import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from arramon_client.environments.two_agents import raw_env
from arramon_client.world import STEPS_PER_PHASE, Action
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Limits
from benchmarks.common import (
    add_data,
    add_json,
    add_rounds,
    data_or_sample,
    largest_split,
    parser_of,
    text_table,
    write_json,
)
from benchmarks.simulation.peers import frames_per_second

COUNT = 16
"""Episodes of a vector environment, and of the bare camera."""

MOST_STEPS = 4 * STEPS_PER_PHASE - 1
"""Maximum number of measured steps of each episode: nothing is picked up or placed, so each reaches its step limits."""

PEER_SECONDS = 3.0
"""Duration of a measurement of another environment."""

PEERS = {"miniworld": "MiniWorld, 224x224, RGB", "babyai": "MiniGrid's BabyAI, no images"}

Measured = tuple[float, float]
"""Steps per second, and milliseconds of this process's CPU time per step; 0 where it is not known."""

Measure = Callable[[], Measured | None]
"""Measures one round of a row; None if it is not available here."""


@dataclass
class EnvironmentRow:
    """A row of the table: its measurement, and the results by round."""

    name: str
    measure: Measure
    results: list[Measured] = field(default_factory=list)

    @property
    def rate(self) -> float:
        """Median of the steps per second."""
        return statistics.median(rate for rate, _ in self.results)

    @property
    def cost(self) -> float:
        """Median of the CPU time per step, in milliseconds."""
        return statistics.median(cost for _, cost in self.results)


@dataclass(frozen=True)
class RecordedWalk:
    """The random walk that all rows play.

    Attributes:
        episodes: episodes of the split, repeated if it has too few.
        actions: (steps, episodes), forward, left or right at random.
    """

    episodes: Sequence[Episode]
    actions: npt.NDArray[np.int64]

    @classmethod
    def of(cls, split: Split, steps: int) -> "RecordedWalk":
        """Return the walk through the first episodes of a split."""
        episodes = list(islice(cycle(split.in_playing_order(min(split.languages))), COUNT))
        return cls(episodes, np.random.default_rng(0).integers(0, 3, (steps, COUNT)))

    @property
    def ids(self) -> list[str]:
        """Ids of the episodes."""
        return [episode.episode_id for episode in self.episodes]

    @property
    def size(self) -> int:
        """Number of all steps."""
        return int(self.actions.size)


def timed(play: Callable[[], None], steps: int) -> Measured:
    """Time a function that takes a number of steps."""
    started, worked = time.perf_counter(), time.process_time()
    play()
    return steps / (time.perf_counter() - started), 1e3 * (time.process_time() - worked) / steps


def measure_bare(
    split: Split, walk: RecordedWalk, size: int, share: slice = slice(None), *, turns: bool = True
) -> Measure:
    """Return the measurement of rules and frames alone, of all episodes or a share of them.

    Args:
        split: of the episodes.
        walk: the walk to play.
        size: side length of the frames, in pixels.
        share: of the episodes.
        turns: whether the episodes take turns, step by step; otherwise they are played one after another.
    """
    worlds, limits = Worlds({split.name: split}), Limits()
    episodes, actions = walk.episodes[share], walk.actions[:, share].tolist()

    def advance(session: EpisodeSession, action: int) -> None:
        session.apply(Action(action))
        worlds.world(split.name, session.episode).render(session.state, size)

    def begin(episode: Episode) -> EpisodeSession:
        world = worlds.world(split.name, episode)
        session = EpisodeSession(episode, world, limits)
        world.render(session.state, size)
        return session

    def measure() -> Measured:
        sessions = [begin(episode) for episode in episodes]

        def play() -> None:
            if turns:
                for row in actions:
                    for session, action in zip(sessions, row, strict=True):
                        advance(session, action)
                return
            for number, episode in enumerate(episodes):
                session = begin(episode)  # a single environment is reset here
                for row in actions:
                    advance(session, row[number])

        return timed(play, len(actions) * len(episodes))

    return measure


def measure_bare_in_processes(split: Split, walk: RecordedWalk, size: int, count: int) -> Measure:
    """Return the measurement of rules and frames alone in processes that draw at the same time; their rates are added.

    The processes are forked after compilation, and start together once each has rendered all its episodes.
    """
    context = multiprocessing.get_context("fork")

    def draw(share: slice, ready: Any, pipe: Any) -> None:
        measure = measure_bare(split, walk, size, share)
        measure()
        ready.wait()
        pipe.send(measure())

    def measure() -> Measured:
        ready, running = context.Barrier(count), []
        for number in range(count):
            pipe, other = context.Pipe(duplex=False)
            process = context.Process(target=draw, args=(slice(number, None, count), ready, other))
            process.start()
            running.append((process, pipe))
        results: list[Measured] = [pipe.recv() for _, pipe in running]
        for process, _ in running:
            process.join()
        return sum(rate for rate, _ in results), statistics.mean(cost for _, cost in results)

    return measure


def measure_single(data: Path, split: Split, walk: RecordedWalk, size: int) -> Measure:
    """Return the measurement of one episode at a time."""

    def measure() -> Measured:
        env: Any = gymnasium.make("arramon/ArraMon-v0", data=data, split=split.name, image_size=size)
        env.reset(options={"episode": walk.ids[0]})

        def play() -> None:
            for number, episode_id in enumerate(walk.ids):
                env.reset(options={"episode": episode_id})
                for action in walk.actions[:, number]:
                    env.step(action)

        return timed(play, walk.size)

    return measure


def measure_vector(data: Path, split: Split, walk: RecordedWalk, size: int, processes: int) -> Measure:
    """Return the measurement of many episodes at once."""

    def measure() -> Measured:
        env: Any = gymnasium.make_vec(
            "arramon/ArraMon-v0", COUNT, processes=processes, data=data, split=split.name, image_size=size
        )
        env.reset(options={"episode": walk.ids})

        def play() -> None:
            for actions in walk.actions:
                env.step(actions)

        measured = timed(play, walk.size)
        env.close()
        return measured

    return measure


def measure_first_ready(data: Path, split: Split, walk: RecordedWalk, size: int, processes: int) -> Measure:
    """Return the measurement of batches of the first half of the episodes that is ready.

    Each episode takes its own actions in order, but the faster ones take more: with the same number of steps in all, a
    faster process plays further. An episode that has used up its actions repeats them.
    """

    def measure() -> Measured:
        env: Any = gymnasium.make_vec(
            "arramon/ArraMon-v0",
            COUNT,
            processes=processes,
            batch_size=COUNT // 2,
            data=data,
            split=split.name,
            image_size=size,
        )
        env.async_reset(options={"episode": walk.ids})
        taken = np.zeros(COUNT, np.int64)

        def play() -> None:
            for _ in range(2 * len(walk.actions)):
                *_, infos = env.recv()
                numbers = infos["env_id"]
                env.send(walk.actions[taken[numbers] % len(walk.actions), numbers], numbers)
                taken[numbers] += 1

        measured = timed(play, walk.size)
        env.close()
        return measured

    return measure


def measure_two_agents(data: Path, split: Split, walk: RecordedWalk, size: int) -> Measure:
    """Return the measurement of PettingZoo's interface."""

    def measure() -> Measured:
        env = raw_env(data=data, split=split.name, image_size=size)
        env.reset(options={"episode": walk.ids[0]})

        def play() -> None:
            for number, episode_id in enumerate(walk.ids):
                env.reset(options={"episode": episode_id})
                for action in walk.actions[:, number]:
                    env.last()
                    env.step(action)

        return timed(play, walk.size)

    return measure


def measure_peer(python: str, name: str) -> Measure:
    """Return the measurement of another environment; None if it is not installed."""

    def measure() -> Measured | None:
        rate = frames_per_second(python, name, PEER_SECONDS)
        return None if rate is None else (rate, 0.0)

    return measure


def rows_of(data: Path, split: Split, walk: RecordedWalk, peers: str) -> list[EnvironmentRow]:
    """Return the rows of the table."""
    return [
        EnvironmentRow("bare camera with rules, 224", measure_bare(split, walk, 224)),
        EnvironmentRow("bare, one after another, 224", measure_bare(split, walk, 224, turns=False)),
        EnvironmentRow("bare camera, two processes, 224", measure_bare_in_processes(split, walk, 224, 2)),
        EnvironmentRow("one episode, 224", measure_single(data, split, walk, 224)),
        EnvironmentRow("16, one process, 224", measure_vector(data, split, walk, 224, 1)),
        EnvironmentRow("16, two processes, 224", measure_vector(data, split, walk, 224, 2)),
        EnvironmentRow("first 8 of 16, one process, 224", measure_first_ready(data, split, walk, 224, 1)),
        EnvironmentRow("first 8 of 16, two processes, 224", measure_first_ready(data, split, walk, 224, 2)),
        EnvironmentRow("two agents by turns, 224", measure_two_agents(data, split, walk, 224)),
        EnvironmentRow("bare camera with rules, 64", measure_bare(split, walk, 64)),
        EnvironmentRow("bare camera, two processes, 64", measure_bare_in_processes(split, walk, 64, 2)),
        EnvironmentRow("16, one process, 64", measure_vector(data, split, walk, 64, 1)),
        EnvironmentRow("16, two processes, 64", measure_vector(data, split, walk, 64, 2)),
        EnvironmentRow("first 8 of 16, one process, 64", measure_first_ready(data, split, walk, 64, 1)),
        EnvironmentRow("first 8 of 16, two processes, 64", measure_first_ready(data, split, walk, 64, 2)),
        *(EnvironmentRow(title, measure_peer(peers, name)) for name, title in PEERS.items()),
    ]


def table(rows: Sequence[EnvironmentRow]) -> str:
    """Return the table, followed by the main ratios."""
    base, cells = rows[0].rate, []
    for row in rows:
        if not row.results:
            cells.append((row.name, "not here", "", ""))
            continue
        cost = f"{row.cost:.3f}" if row.cost else ""
        cells.append((row.name, f"{row.rate:.0f}", f"{row.rate / base:.2f}", cost))
    lines = [text_table(("RGB + depth", "steps/s", "of bare", "CPU ms a step"), cells)]
    by_name = {row.name: row for row in rows}
    one, two = by_name["16, one process, 224"], by_name["16, two processes, 224"]
    small, drawn_by_two = by_name["16, one process, 64"], by_name["bare camera, two processes, 224"]
    single_row, alone = by_name["one episode, 224"], by_name["bare, one after another, 224"]
    lines.append(
        f"of the bare camera, one episode (one after another): {rate_ratio(single_row, alone):.2f}, by CPU time "
        f"{alone.cost / single_row.cost:.2f}; 16 in one process: {rate_ratio(one, rows[0]):.2f}, by CPU time "
        f"{rows[0].cost / one.cost:.2f}\n"
        f"two processes of one: {rate_ratio(two, one):.2f}, "
        f"of the bare camera {rate_ratio(drawn_by_two, rows[0]):.2f}; "
        f"64x64 of 224: {rate_ratio(small, one):.2f}"
    )
    lines += [
        f"at {size}, two processes of 16 in one in lockstep: "
        f"lockstep {rate_ratio(by_name[f'16, two processes, {size}'], by_name[f'16, one process, {size}']):.2f}, "
        "first 8 "
        f"{rate_ratio(by_name[f'first 8 of 16, two processes, {size}'], by_name[f'16, one process, {size}']):.2f}; "
        "the bare camera in two of one: "
        f"{rate_ratio(by_name[f'bare camera, two processes, {size}'], by_name[f'bare camera with rules, {size}']):.2f}"
        for size in (224, 64)
    ]
    return "\n".join(lines)


def rate_ratio(row: EnvironmentRow, other: EnvironmentRow) -> float:
    """Return the median over rounds of the ratio of one row's rate to another's."""
    return statistics.median(one[0] / two[0] for one, two in zip(row.results, other.results, strict=True))


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument("--steps", type=int, default=300, help=f"of each episode in a measurement, 1 to {MOST_STEPS}")
    add_rounds(parser, 5)
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has MiniWorld and MiniGrid")
    add_json(parser)
    options = parser.parse_args()
    if not 1 <= options.steps <= MOST_STEPS:
        parser.error(f"--steps is {options.steps}, expected 1 to {MOST_STEPS}")
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        rows = rows_of(data, split, RecordedWalk.of(split, options.steps), options.peers)
        for _ in range(options.rounds):
            for row in rows:
                measured = row.measure()
                row.results += [] if measured is None else [measured]
    print(f"split {split.name}, {len(split.episodes)} episodes\n{table(rows)}")
    write_json(options.json, {row.name: row.results for row in rows})


if __name__ == "__main__":
    main()
