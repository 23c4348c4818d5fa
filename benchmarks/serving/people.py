"""Milliseconds from a person's key to the frame, with many people beside two agents, and what this costs the agents.

    python -m benchmarks.serving.people [--data DIR] [--people 50] [--size 448] [--pause 4] [--seconds 20] [--json FILE]

Each person is a WebSocket of the play page without a browser. It presses ten keys, one every tenth of a second or as
soon as the last frame has come, and then reads for `--pause` seconds on average, as people do at a corner. People play
in a process of their own; the agents are random walks at full speed in this one. The agents are measured alone, then
beside the people, then alone again.
"""

import asyncio
import json
import multiprocessing
import random
import time
from argparse import Namespace
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection

import aiohttp

from arramon_client.play import Settings
from arramon_client.transport.connection import connect
from benchmarks.common import (
    add_data,
    add_json,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    positive_float,
    positive_int,
    text_table,
    write_json,
)
from benchmarks.serving.play import (
    TimedRandomWalk,
    background_play,
    build_all_sections,
    measure_play,
    percentiles,
    run_request,
)
from benchmarks.serving.server import ServerSetting, running_server

AGENTS, PARALLEL = 2, 8
"""Number of agents, and of the episodes that each has open."""

BURST, KEY_SECONDS = 10, 0.1
"""Keys that a person presses one after the other, and the time from one to the next."""


@dataclass(frozen=True)
class Crowd:
    """What the people did.

    Attributes:
        p50, p99: milliseconds from a key to its frame.
        keys: keys that were pressed.
        lost: keys without an answer, and answers to the wrong step.
        rate: frames per second.
        kilobytes: mean size of a frame.
    """

    p50: float
    p99: float
    keys: int
    lost: int
    rate: float
    kilobytes: float


@dataclass
class Tally:
    """Waits in seconds, frame sizes in bytes, and counts of all people."""

    waits: list[float]
    sizes: list[int]
    keys: int = 0
    lost: int = 0
    is_measuring: bool = False


async def play_person(number: int, url: str, options: Namespace, split: str, language: str, tally: Tally) -> None:
    """Play episodes until cancelled."""
    chance = random.Random(number)  # noqa: S311 - no secret
    new = {"split": split, "language": language, "episodes": 1}
    hello = {"type": "hello", "player": f"{number:016x}", "token": "", "size": options.size}
    async with aiohttp.ClientSession() as session:
        while True:
            async with session.ws_connect(f"{url}/play/socket", headers={"Origin": url}) as socket:
                await socket.send_str(json.dumps({**hello, "new": new}))
                await _play_run(socket, chance, options.pause, tally)


async def _play_run(socket: aiohttp.ClientWebSocketResponse, chance: random.Random, pause: float, tally: Tally) -> None:
    pressed, state = 0.0, None
    async for message in socket:
        if message.type is aiohttp.WSMsgType.TEXT:
            said = json.loads(message.data)
            if said["type"] in ("closed", "problem"):
                raise RuntimeError(f"the server refused a key: {said}")
            if said["type"] == "run_ended":
                return
            if said["type"] == "state":
                tally.lost += state is not None and said["step"] != state["step"] + 1
                state = said
            continue
        if pressed and tally.is_measuring:
            tally.waits.append(time.perf_counter() - pressed)
            tally.sizes.append(len(message.data))
        assert state is not None
        is_reading = state["step"] % BURST == 0
        next_key = pressed + KEY_SECONDS if not is_reading else time.perf_counter() + pause * chance.uniform(0.5, 1.5)
        await asyncio.sleep(max(0.0, next_key - time.perf_counter()))
        pressed = time.perf_counter()
        tally.keys += 1
        key = {"type": "key", "episode": state["episode"], "step": state["step"], "action": chance.choice((0, 0, 1, 2))}
        await socket.send_str(json.dumps(key))


async def _crowd(url: str, options: Namespace, split: str, language: str, pipe: Connection) -> None:
    tally = Tally([], [])
    people = [
        asyncio.create_task(play_person(number, url, options, split, language, tally))
        for number in range(options.people)
    ]
    await asyncio.sleep(options.pause)  # They come one after the other, and do not read in step.
    pipe.send("playing")
    await asyncio.to_thread(pipe.recv)
    tally.is_measuring, started = True, time.perf_counter()
    await asyncio.to_thread(pipe.recv)
    tally.is_measuring, elapsed = False, time.perf_counter() - started
    for person in people:
        person.cancel()
    ended = await asyncio.gather(*people, return_exceptions=True)
    for error in ended:
        if error is not None and not isinstance(error, asyncio.CancelledError):
            raise error
    p50, p99 = percentiles(sorted(tally.waits))
    size = sum(tally.sizes) / len(tally.sizes) / 1000
    pipe.send(asdict(Crowd(p50, p99, tally.keys, tally.lost, len(tally.waits) / elapsed, size)))


def run_crowd(url: str, options: Namespace, split: str, language: str, pipe: Connection) -> None:
    """Play as all people, in a process of their own."""
    asyncio.run(_crowd(url, options, split, language, pipe))


def main() -> None:
    """Measure, and print the table."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument("--people", type=positive_int, default=50, metavar="N", help="people (default: %(default)s)")
    parser.add_argument("--size", type=positive_int, default=448, metavar="N", help="image size (default: %(default)s)")
    parser.add_argument(
        "--pause", type=positive_float, default=4.0, metavar="S", help="seconds between bursts (default: %(default)s)"
    )
    add_seconds(parser, 20.0, "duration of each measurement")
    add_json(parser)
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        more = ("--web", "127.0.0.1:0", "--play-image-sizes", str(options.size))
        setting = ServerSetting("people", more=more)
        with running_server(data, setting) as server, connect(server.address) as connection, ExitStack() as stack:
            request = run_request(split)
            build_all_sections(connection, request, options.seconds)
            agents = [TimedRandomWalk() for _ in range(AGENTS)]
            for agent in agents:
                stack.enter_context(
                    background_play(connection, request, agent, Settings(PARALLEL), warm_up=options.seconds)
                )
            before = _agents_rate(agents, options.seconds)
            here, there = multiprocessing.Pipe()
            language = min(split.languages)
            process = multiprocessing.get_context("spawn").Process(
                target=run_crowd, args=(server.pages, options, split.name, language, there), daemon=True
            )
            process.start()
            there.close()
            here.recv()
            here.send("measure")
            beside = _agents_rate(agents, options.seconds)
            here.send("stop")
            crowd = Crowd(**here.recv())
            process.join()
            after = _agents_rate(agents, options.seconds)
    alone = (before + after) / 2
    loss = 1 - beside / alone
    header = ["", "p50 ms", "p99 ms", "frames/s", "kB a frame", "keys", "lost"]
    row = [f"{options.people} people at {options.size}", f"{crowd.p50:.1f}", f"{crowd.p99:.1f}", f"{crowd.rate:.1f}"]
    print(text_table(header, [[*row, f"{crowd.kilobytes:.0f}", str(crowd.keys), str(crowd.lost)]]))
    print(f"{AGENTS} agents: {alone:.0f} steps/s alone, {beside:.0f} beside the people, a loss of {100 * loss:.0f}%")
    write_json(options.json, {**asdict(crowd), "agents_alone": alone, "agents_beside": beside})


def _agents_rate(agents: list[TimedRandomWalk], seconds: float) -> float:
    """Return the steps per second of all agents together."""
    for agent in agents[1:]:
        agent.reset()
    started = time.perf_counter()
    first = measure_play(agents[0], seconds)
    return first.rate + sum(agent.steps for agent in agents[1:]) / (time.perf_counter() - started)


if __name__ == "__main__":
    main()
