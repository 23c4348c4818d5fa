"""Benchmark of many streams: server memory with idle streams, and latency of those that play.

    python -m benchmarks.serving.streams [--data DIR] [--streams 1 100 1000] [--playing 64] [--seconds 5] [--json FILE]

Each stream is a separate client with one episode, over TCP on the loopback, with raw RGB and depth of 224x224. All
clients are in this process: latency is measured from sending an action to receiving its observation, and includes their
own work. The memory of the first streams includes the sections, which are built when they are first played.
"""

import argparse
import asyncio
import json
import random
import statistics
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2, types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.transport.connection import CHANNEL_OPTIONS, METADATA
from arramon_server.episodes.splits import read_splits
from benchmarks.common import data_or_sample
from benchmarks.serving.steps import SENSORS, Setting, family, resident, serving

Figures = dict[str, float]


class Client:
    """One stream with one episode.

    Attributes:
        waits: seconds from each action to its observation.
    """

    def __init__(self, stub: EvaluationStub, run_id: str) -> None:
        self.waits: list[float] = []
        self._stub: Any = stub  # asynchronous, contrary to the stub's types
        self._run_id = run_id

    async def open(self) -> None:
        """Open the stream, and wait for the first observation."""
        self._call = self._stub.Play(metadata=METADATA)
        opening = evaluation_pb2.Open(run_id=self._run_id, max_episodes=1, encoding=types_pb2.ENCODING_RAW)
        await self._call.write(evaluation_pb2.PlayRequest(open=opening))
        self._seen = await anext(self._observations())

    async def play(self, until: float) -> None:
        """Take random actions until a time of `time.perf_counter`."""
        chance = random.Random(self._run_id)  # noqa: S311
        while time.perf_counter() < until:
            action = types_pb2.Action.ValueType(chance.randrange(4))
            act = evaluation_pb2.Act(episode_id=self._seen.episode_id, step=self._seen.step, action=action)
            started = time.perf_counter()
            await self._call.write(evaluation_pb2.PlayRequest(actions=evaluation_pb2.ActionBatch(acts=[act])))
            self._seen = await anext(self._observations())
            self.waits.append(time.perf_counter() - started)

    def close(self) -> None:
        """Cancel the stream."""
        self._call.cancel()

    async def _observations(self) -> AsyncIterator[evaluation_pb2.Observation]:
        while True:
            response = await self._call.read()
            for event in response.events:
                if event.WhichOneof("event") == "observation":
                    yield event.observation


async def measured(address: str, process_id: int, split: str, streams: int, playing: int, seconds: float) -> Figures:
    """Open streams, measure the server's memory, and play on some of them."""
    async with grpc.aio.insecure_channel(address, options=CHANNEL_OPTIONS) as channel:
        stub: Any = EvaluationStub(channel)
        request = evaluation_pb2.CreateRunRequest(agent="streams", split=split, language="en", sensors=SENSORS)
        run = await stub.CreateRun(request, metadata=METADATA)
        clients = [Client(stub, run.run_id) for _ in range(streams)]
        before = memory(process_id)
        for client in clients:
            await client.open()
        await asyncio.sleep(1.0)
        idle = memory(process_id)
        until = time.perf_counter() + seconds
        await asyncio.gather(*(client.play(until) for client in clients[:playing]))
        waits = sorted(wait for client in clients for wait in client.waits)
        for client in clients:
            client.close()
        await stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    return {
        "idle MB": idle,
        "MB a stream": (idle - before) / streams,
        "playing MB": memory(process_id),
        "steps/s": len(waits) / seconds,
        "p50 ms": 1e3 * statistics.median(waits),
        "p99 ms": 1e3 * waits[len(waits) * 99 // 100],
    }


def memory(process_id: int) -> float:
    """Return the resident memory of a server's processes, in MB."""
    return sum(map(resident, family(process_id)))


def main() -> int:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--streams", type=int, nargs="+", default=[1, 100, 1000], help="numbers of open streams")
    parser.add_argument(
        "--playing", type=int, default=64, help="maximum number of streams that play (default: %(default)s)"
    )
    parser.add_argument("--seconds", type=float, default=5.0, help="duration of play (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="output file for the results")
    options = parser.parse_args()
    rows: dict[int, Figures] = {}
    with data_or_sample(options.data) as data, serving(data, Setting("streams", tcp=True)) as (address, process, _):
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        for streams in options.streams:
            if streams > len(split.episodes):
                print(f"{streams} streams need as many episodes; split {split.name} has {len(split.episodes)}")
                continue
            arguments = address, process.pid, split.name, streams, options.playing, options.seconds
            rows[streams] = asyncio.run(measured(*arguments))
    names = list(next(iter(rows.values())))
    print(f"{'streams':>8}" + "".join(f"{name:>13}" for name in names))
    for streams, figures in rows.items():
        print(f"{streams:8}" + "".join(f"{figures[name]:13.1f}" for name in names))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
