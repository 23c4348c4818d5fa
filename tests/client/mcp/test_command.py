"""The command `arramon-client mcp`: as a host starts it, over HTTP, and with wrong options."""

import asyncio
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from mcp import Client

import arramon_client.cli
from tests import forked, tiny
from tests.client.fake import Servicer, World, serving
from tests.client.mcp.players import Player, data_of
from tests.client.mcp.processes import START, HttpProcess, StdioProcess

INITIALIZE = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}},
}
HEADERS = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}


@pytest.fixture
def http(world: World) -> Iterator[HttpProcess]:
    with serving(Servicer(world)) as address:
        process = HttpProcess(address)
        yield process
        assert process.stop() == 143


def test_a_host_plays_on_this_machine(tmp_path: Path) -> None:
    """Over standard input and output with an embedded server, in two processes one after the other."""
    tiny.write(tmp_path / "data", count=1)
    process = StdioProcess(tmp_path, "--data", str(tmp_path / "data"))

    async def play() -> None:
        async with Client(process.parameters, mode="legacy") as client:
            assert client.instructions is not None
            assert "INTERACT picks up" in client.instructions
            run = data_of(await client.call_tool("start", START))["run"]["id"]
            act = {"run": run, "episode": "0", "step": 0, "actions": ["FORWARD", "FORWARD"]}
            before = data_of(await client.call_tool("act", act))
            assert (before["taken"], before["episode"]["step"]) == (2, 2)
            assert "seconds_left" not in before["episode"]
        async with Client(process.parameters) as client:
            assert data_of(await client.call_tool("act", act)) == before
            names = [
                "INTERACT",
                "FORWARD",
                "INTERACT",
                *["RIGHT"] * 3,
                "FORWARD",
                "FORWARD",
                "INTERACT",
                "FORWARD",
                "INTERACT",
            ]
            step = 2
            while names:
                act = {"run": run, "episode": "0", "step": step, "actions": names}
                seen = data_of(await client.call_tool("act", act))
                names, step = names[seen["taken"] :], step + seen["taken"]
            assert (step, seen["episode"]["cause"]) == (len(tiny.ACTIONS), "AGENT_FINISHED")
            report = data_of(await client.call_tool("report", {"run": run, "episodes": True}))
            assert report["scores"]["total"]["nDTW"]["mean"] == 1
            assert [episode["steps"] for episode in report["episodes"]] == [len(tiny.ACTIONS)]
            assert len(report["receipt"]) == 64
            again = data_of(await client.call_tool("act", act))
            assert (again["taken"], again["episode"]) == (seen["taken"], seen["episode"])
            listed = data_of(await client.call_tool("runs", {}))["runs"]
            assert [(run["id"], run["state"]) for run in listed] == [(run, "complete")]

    asyncio.run(play())


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_an_embedded_server_that_is_killed_is_restarted(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data", count=1)
    process = StdioProcess(tmp_path, "--data", str(tmp_path / "data"))

    async def play() -> None:
        async with Client(process.parameters) as client:
            run = data_of(await client.call_tool("start", START))["run"]["id"]
            for step in range(3):
                children = Path(f"/proc/{process.pid}/task").glob("*/children")
                for child in " ".join(path.read_text() for path in children).split():
                    os.kill(int(child), signal.SIGKILL)
                act = {"run": run, "episode": "0", "step": step, "actions": ["LEFT"]}
                assert data_of(await client.call_tool("act", act))["episode"]["step"] == step + 1

    asyncio.run(play())


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_clients_play_over_http(http: HttpProcess, world: World, mode: str) -> None:
    async def play() -> None:
        async with Player(lambda: Client(http.url, mode=mode)) as player:
            run = (await player.data("start", **{**START, "sensors": []}))["run"]["id"]
            await player.play(run)
        assert player.acts == world.actions

    asyncio.run(play())


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Origin": "http://localhost:3000"}, 200),
        ({"Origin": "https://evil.example"}, 403),
        ({"Origin": "http://localhost.evil.example"}, 403),
        ({"Host": "evil.example"}, 421),
        ({"Host": "localhost.evil.example:80"}, 421),
        ({"Content-Type": "text/plain"}, 400),
    ],
)
def test_web_pages_of_other_origins_are_refused(http: HttpProcess, headers: dict[str, str], status: int) -> None:
    answer = httpx2.post(http.url, json=INITIALIZE, headers={**HEADERS, **headers})
    assert answer.status_code == status


def test_a_proxy_and_a_web_page_can_be_allowed(world: World) -> None:
    with serving(Servicer(world)) as address:
        process = HttpProcess(address, "--allow-host", "proxy.example", "--allow-origin", "https://editor.example")
        for host in ("proxy.example", "proxy.example:8443"):
            headers = {**HEADERS, "Host": host, "Origin": "https://editor.example"}
            assert httpx2.post(process.url, json=INITIALIZE, headers=headers).status_code == 200
        assert httpx2.post(process.url, json=INITIALIZE, headers={**HEADERS, "Host": "other"}).status_code == 421
        assert process.stop() == 143


def test_huge_and_broken_requests_are_refused(http: HttpProcess) -> None:
    assert httpx2.post(http.url, content=b" " * 5_000_000, headers=HEADERS).status_code == 413
    assert httpx2.post(http.url, content=b"{", headers=HEADERS).status_code == 400
    assert httpx2.post(http.url, json=INITIALIZE, headers=HEADERS).status_code == 200


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--http", "0.0.0.0:80"], "--http 0.0.0.0:80 can be reached from other machines, whose users would play with"),
        (["--http", "host.example:80"], "can be reached from other machines"),
        (["--http", "80"], "--http is '80', expected HOST:PORT, such as 127.0.0.1:8300"),
        (["--http", "127.0.0.1:70000"], "expected HOST:PORT"),
        (["--allow-origin", "https://editor.example"], "--allow-host and --allow-origin apply to --http"),
        (["--server", "127.0.0.1:1", "--data", "x"], "--data applies to runs on this machine"),
        (["--parallel", "0"], "--parallel"),
    ],
)
def test_wrong_options_are_refused(arguments: list[str], message: str) -> None:
    done = forked.run("mcp", *arguments, command=arramon_client.cli.main)
    assert done.returncode == 2
    assert message in done.stderr


def test_without_its_extra_the_command_names_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [each for each in sys.modules if each.startswith("arramon_client.mcp.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    assert arramon_client.cli.main(["mcp"]) == 2
    assert "pip install 'arramon-client[mcp]'" in capsys.readouterr().err
