"""The tools on a host: clocks and limits in every result, and runs of other participants."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import tiny
from tests.api.people import token_of
from tests.client.mcp.conftest import tools_on
from tests.client.mcp.players import data_of, text_of
from tests.serving import Server

START = {"language": "en", "agent": "mine", "split": "tiny", "episodes": 1}
STEP_SECONDS, BANK_SECONDS = 600, 1000


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path, count=2)
    tiny.write(tmp_path, "secret", 1, hidden=True)
    clocks = ("--step-seconds", str(STEP_SECONDS), "--bank-seconds", str(BANK_SECONDS))
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8", "--no-anonymous", *clocks)
    yield server
    assert server.stop() == 0


def test_clocks_and_limits_are_in_every_result(server: Server) -> None:
    async def play() -> None:
        async with tools_on(server.address, token=token_of(server.data, "lab")) as client:
            started = data_of(await client.call_tool("start", {**START, "language": "hi"}))
            run = {"run": started["run"]["id"]}
            looked = data_of(await client.call_tool("look", run))
            act = {**run, "episode": looked["episode"]["id"], "step": 0, "actions": ["LEFT"]}
            acted = data_of(await client.call_tool("act", act))
            (listed,) = data_of(await client.call_tool("runs", {}))["runs"]
            for each in (started["run"], looked["run"], acted["run"], listed):
                limits = (each["steps_per_phase"], each["step_seconds"], each["bank_seconds"])
                assert limits == (8, STEP_SECONDS, BANK_SECONDS)
                assert (each["episodes"], each["episodes_left"]) == (1, 1)
            assert looked["episode"]["instruction"] == "धारीदार लाल मग तक चलें।"
            assert [each["episode"]["steps_left"] for each in (looked, acted)] == [8, 7]
            later = data_of(await client.call_tool("look", run))
            assert later["episode"]["step"] == 1
            assert BANK_SECONDS < later["episode"]["seconds_left"] <= acted["episode"]["seconds_left"]
            assert acted["episode"]["seconds_left"] <= STEP_SECONDS + BANK_SECONDS

    asyncio.run(play())


def test_runs_of_other_participants_are_not_shown(server: Server) -> None:
    async def play() -> None:
        lab, other = (token_of(server.data, name) for name in ("lab", "other"))
        async with tools_on(server.address, token=lab) as mine, tools_on(server.address, token=other) as theirs:
            run = data_of(await mine.call_tool("start", START))["run"]["id"]
            act = {"run": run, "episode": "0", "step": 0, "actions": ["LEFT"]}
            assert data_of(await theirs.call_tool("runs", {})) == {"runs": [], "more": 0}
            for tool, arguments in (("look", {"run": run}), ("act", act), ("report", {"run": run})):
                refused = await theirs.call_tool(tool, arguments)
                assert refused.is_error
                assert f"there is no run {run!r}" in text_of(refused)
            assert data_of(await mine.call_tool("act", act))["episode"]["step"] == 1

    asyncio.run(play())


def test_a_later_process_knows_that_an_episode_of_a_run_that_is_over_has_ended(server: Server) -> None:
    """Of a hidden split, whose single episodes are not disclosed, it does not know why."""

    async def play() -> None:
        lab = token_of(server.data, "lab")
        for split, episodes, cause in (("tiny", 1, "FORFEITED"), ("secret", 0, "UNKNOWN")):
            async with tools_on(server.address, token=lab) as client:
                start = {**START, "split": split, "episodes": episodes}
                run = data_of(await client.call_tool("start", start))["run"]["id"]
                episode = data_of(await client.call_tool("look", {"run": run}))["episode"]["id"]
                over = data_of(await client.call_tool("give_up", {"run": run, "episode": episode, "reason": "test"}))
                assert over["episode"]["cause"] == "FORFEITED"
            async with tools_on(server.address, token=lab) as client:
                act = {"run": run, "episode": episode, "step": 0, "actions": ["LEFT"]}
                repeated = data_of(await client.call_tool("act", act))
                assert (repeated["taken"], repeated["episode"]["ended"]) == (0, True)
                assert repeated["episode"]["cause"] == cause
                report = data_of(await client.call_tool("report", {"run": run, "episodes": True}))
                assert [each["cause"] for each in report["episodes"]] == (["FORFEITED"] if split == "tiny" else [])
                assert "total" in report["scores"]

    asyncio.run(play())
