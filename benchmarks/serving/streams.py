"""Benchmark of many streams: server memory with idle streams, and latency of those that play.

    python -m benchmarks.serving.streams [--data DIR] [--streams 1 100 1000] [--playing 64] [--seconds 5] [--json FILE]

Each stream is a separate client with one episode, over TCP on the loopback, with raw RGB and depth of 224x224. All
clients are in this process: latency is measured from sending an action to receiving its observation, and includes their
own work. The memory of the first streams includes the sections, which are built when they are first played.
"""

import asyncio
import random
import sys
import time
from collections.abc import AsyncIterator
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2, types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.transport.connection import CHANNEL_OPTIONS, METADATA
from benchmarks.common import (
    add_data,
    add_json,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    positive_int,
    text_table,
    write_json,
)
from benchmarks.serving.play import percentiles
from benchmarks.serving.server import SENSORS, MeasuredServer, ServerSetting, running_server

Figures = dict[str, float]


class SingleStream:
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


async def measured(server: MeasuredServer, split: str, streams: int, playing: int, seconds: float) -> Figures:
    """Open streams, measure the server's memory, and play on some of them."""
    async with grpc.aio.insecure_channel(server.address, options=CHANNEL_OPTIONS) as channel:
        stub: Any = EvaluationStub(channel)
        request = evaluation_pb2.CreateRunRequest(agent="streams", split=split, language="en", sensors=SENSORS)
        run = await stub.CreateRun(request, metadata=METADATA)
        clients = [SingleStream(stub, run.run_id) for _ in range(streams)]
        before = server.memory
        for client in clients:
            await client.open()
        await asyncio.sleep(min(seconds, 1.0))
        idle = server.memory
        until = time.perf_counter() + seconds
        await asyncio.gather(*(client.play(until) for client in clients[:playing]))
        waits = sorted(wait for client in clients for wait in client.waits)
        for client in clients:
            client.close()
        await stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    middle, last = percentiles(waits)
    return {
        "idle MB": idle,
        "MB a stream": (idle - before) / streams,
        "playing MB": server.memory,
        "steps/s": len(waits) / seconds,
        "p50 ms": middle,
        "p99 ms": last,
    }


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument(
        "--streams", type=positive_int, nargs="+", default=[1, 100, 1000], help="numbers of open streams"
    )
    parser.add_argument(
        "--playing",
        type=positive_int,
        default=64,
        help="maximum number of streams that play (default: %(default)s)",
    )
    add_seconds(parser, 5.0, "duration of play")
    add_json(parser)
    options = parser.parse_args()
    rows: dict[int, Figures] = {}
    with data_or_sample(options.data) as data, running_server(data, ServerSetting("streams", tcp=True)) as server:
        split = largest_split(data)
        for streams in options.streams:
            if streams > len(split.episodes):
                print(f"{streams} streams need as many episodes; split {split.name} has {len(split.episodes)}")
                continue
            rows[streams] = asyncio.run(measured(server, split.name, streams, options.playing, options.seconds))
    if not rows:
        sys.exit("nothing was measured: give data with more episodes")
    names = list(next(iter(rows.values())))
    lines = [[str(streams), *(f"{figures[name]:.1f}" for name in names)] for streams, figures in rows.items()]
    print(text_table(["streams", *names], lines))
    write_json(options.json, rows)


if __name__ == "__main__":
    main()
