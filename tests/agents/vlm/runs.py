"""Runs of the real client with the agent: a split whose instructions differ, and its expert behind a fake endpoint."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.splits import write_split
from benchmarks.agents.fake_endpoint import Expert, FakeEndpoint
from tests import tiny
from tests.forked import ForkedClient

PLAN = 2

PHASES = ((0, 3), (3, 5), (5, 11), (11, 13))
"""First and last step of each phase of `tiny.ACTIONS`."""

CALLS = 7
"""Calls that an episode takes with plans of PLAN actions."""


def write(data: Path, count: int) -> None:
    """Writes a split in which every instruction is another one, so that no two calls are alike."""
    episodes = []
    for number in range(count):
        episode = tiny.episode(str(number))
        texts = {
            code: (numbered(both[0], f"{number}-0"), numbered(both[1], f"{number}-1"))
            for code, both in episode.instructions.items()
        }
        episodes.append(replace(episode, instructions=texts))
    write_split(data, "tiny", hidden=False, source="tests", episodes=episodes, sections=[tiny.SECTION])


def numbered(texts: Instructions, number: str) -> Instructions:
    """The texts with a number after each."""
    return Instructions(f"{texts.navigation} {number}", f"{texts.assembly} {number}")


def expert(count: int, delay: float = 0.0) -> Expert:
    """The behaviour that knows the ground truth of that split, in both languages."""
    actions: dict[str, Sequence[int]] = {}
    for number in range(count):
        for both in tiny.episode(str(number)).instructions.values():
            for turn, each in enumerate(both):
                for offset, text in enumerate((each.navigation, each.assembly)):
                    begin, end = PHASES[2 * turn + offset]
                    actions[f"{text} {number}-{turn}"] = tiny.ACTIONS[begin:end]
    return Expert(actions, PLAN, delay)


def client(server: str, endpoint: FakeEndpoint, output: Path, *more: str, language: str = "en") -> ForkedClient:
    """`arramon-client` with the agent, four episodes at a time."""
    given = ["model=m", f"endpoint={endpoint.url}", f"plan={PLAN}"]
    arguments = ["--agent", "agents.vlm", "--lang", language, "--server", server, "--parallel", "4"]
    arguments += ["--output", str(output), "--quiet", *more]
    return ForkedClient([*arguments, *(word for each in given for word in ("--agent-arg", each))])


def trace_of(output: Path) -> list[dict[str, Any]]:
    """The records of the only trace; a last line that a kill has cut off is left out."""
    lines = [line for path in output.glob("*.vlm.jsonl") for line in path.read_bytes().splitlines(keepends=True)]
    return [json.loads(line) for line in lines if line.endswith(b"\n")]


def calls_of(output: Path) -> list[tuple[str, int, str]]:
    """Episode, step and prompt of each answered call in the trace."""
    return [(each["episode"], each["step"], each["prompt"]) for each in trace_of(output) if each["kind"] == "call"]
