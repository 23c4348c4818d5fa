"""The tools, called by the client of the package `mcp`, on a scripted server."""

import asyncio
import base64
import io
from typing import Any

import pytest
from mcp import Client, MCPError
from mcp.types import ImageContent
from PIL import Image

from arramon.v1 import types_pb2
from tests.client.fake import RUN, World
from tests.client.mcp.conftest import Connect
from tests.client.mcp.players import data_of, text_of

OTHER = "2" * 32
CURRENT, BEFORE = "2026-07-28", "2025-11-25"


async def started(client: Client, **more: Any) -> str:
    data = data_of(await client.call_tool("start", {"language": "en", "agent": "mine", "sensors": [], **more}))
    run: str = data["run"]["id"]
    return run


async def acted(client: Client, step: int, *actions: str, episode: str = "e0", **more: Any) -> dict[str, Any]:
    arguments = {"run": RUN, "episode": episode, "step": step, "actions": list(actions), **more}
    return data_of(await client.call_tool("act", arguments))


async def refused(client: Client, tool: str, **arguments: Any) -> str:
    """Call a tool that must fail; return its error."""
    result = await client.call_tool(tool, arguments)
    assert result.is_error
    assert result.structured_content is None
    return text_of(result)


@pytest.mark.parametrize(("mode", "version"), [("auto", CURRENT), (CURRENT, CURRENT), ("legacy", BEFORE)])
def test_a_run_is_played_by_the_current_protocol_and_the_one_before(
    connect: Connect, world: World, mode: str, version: str
) -> None:
    async def play() -> None:
        async with connect(mode) as client:
            assert client.protocol_version == version
            if mode != CURRENT:  # Otherwise this client asks for none.
                assert "INTERACT picks up" in (client.instructions or "")
            seen = data_of(await client.call_tool("look", {"run": await started(client)}))
            while seen["run"]["state"] == "running":
                episode = seen["episode"]
                if episode["ended"]:
                    seen = data_of(await client.call_tool("look", {"run": RUN}))
                    continue
                assert (episode["turn"], episode["phase"]) == (1, "navigation")
                assert episode["steps_left"] == 5 - episode["step"]
                assert episode["instruction"] == f"go {episode['step']}"
                seen = await acted(client, episode["step"], "LEFT", episode=episode["id"])
            assert (seen["run"]["episodes_left"], seen["next"]) == (0, "the run is over: call `report`")
            assert "episode" not in data_of(await client.call_tool("look", {"run": RUN}))

    asyncio.run(play())
    assert world.actions == {f"e{i}": [1] * 5 for i in range(4)}


def test_tools_say_what_they_do(connect: Connect) -> None:
    async def list_tools() -> dict[str, tuple[bool | None, bool | None]]:
        async with connect() as client:
            tools = (await client.list_tools()).tools
        assert all(tool.description and tool.output_schema and tool.annotations for tool in tools)
        return {
            tool.name: (tool.annotations.read_only_hint, tool.annotations.idempotent_hint)
            for tool in tools
            if tool.annotations
        }

    assert asyncio.run(list_tools()) == {
        "start": (False, False),
        "runs": (True, True),
        "look": (True, True),
        "act": (False, True),
        "give_up": (False, True),
        "report": (True, True),
    }


def test_a_repeated_act_answers_what_was_answered(connect: Connect, world: World) -> None:
    async def play() -> None:
        async with connect() as client:
            await started(client)
            first = await acted(client, 0, "LEFT", "RIGHT", note="at the corner")
            assert (first["taken"], first["stopped"], first["episode"]["step"]) == (2, "", 2)
            assert await acted(client, 0, "LEFT", "RIGHT", note="at the corner") == first
            assert await refused(client, "act", run=RUN, episode="e0", step=1, actions=["LEFT"]) == (
                "step 1 of episode e0 was answered with RIGHT, which remains recorded; the present step is 2"
            )
            assert await refused(client, "act", run=RUN, episode="e0", step=3, actions=["LEFT"]) == (
                "step 3 of episode e0 is ahead of the present step, 2"
            )
            last = await acted(client, 2, *["LEFT"] * 9)
            assert (last["taken"], last["stopped"], last["episode"]["cause"]) == (3, "episode over", "AGENT_FINISHED")
            again = await acted(client, 2, *["LEFT"] * 9)
            assert (again["taken"], again["stopped"], again["episode"]) == (3, "episode over", last["episode"])

    asyncio.run(play())
    assert world.actions["e0"] == [1, 2, 1, 1, 1]
    assert world.notes == {("e0", 0): "at the corner"}


def test_a_plan_stops_where_the_way_is_blocked(connect: Connect, world: World) -> None:
    """All frames of the scripted server are identical."""

    async def play() -> None:
        async with connect() as client:
            await started(client, sensors=["rgb"])
            stopped = await acted(client, 0, "LEFT", "FORWARD", "FORWARD")
            assert (stopped["taken"], stopped["stopped"]) == (2, "blocked")
            assert await acted(client, 0, "LEFT", "FORWARD", "FORWARD") == stopped

    asyncio.run(play())
    assert world.actions["e0"] == [1, 0]


def test_another_process_goes_on_with_the_run(connect: Connect, world: World) -> None:
    """The first one is still there, and goes on after it; each step is taken once."""

    async def play() -> None:
        async with connect() as first, connect("legacy") as second:
            await started(first)
            await acted(first, 0, "LEFT")
            before = await acted(first, 1, "RIGHT")
            repeated = await acted(second, 1, "RIGHT")
            assert repeated == before
            await acted(second, 2, "LEFT")
            assert (await acted(first, 3, "RIGHT"))["episode"]["step"] == 4
            message = await refused(second, "act", run=RUN, episode="e0", step=3, actions=["LEFT"])
            assert message.endswith("was answered with RIGHT, which remains recorded; the present step is 4")
            await acted(second, 4, "LEFT")
            message = await refused(first, "act", run=RUN, episode="e0", step=4, actions=["LEFT"])
            assert "is not open: it has ended" in message

    asyncio.run(play())
    assert world.actions["e0"] == [1, 2, 1, 2, 1]


def test_clients_that_act_at_once_take_each_step_once(connect: Connect, world: World) -> None:
    async def play() -> None:
        async with connect() as client:
            await started(client)
            found = await asyncio.gather(*(acted(client, 0, "LEFT", "RIGHT", "LEFT") for _ in range(8)))
            assert found == [found[0]] * 8

    asyncio.run(play())
    assert world.actions["e0"] == [1, 2, 1]


@pytest.mark.parametrize("cut", [{1: "before"}, {2: "after"}, {2: "after", 3: "before", 7: "after"}])
def test_a_broken_stream_changes_nothing(connect: Connect, world: World, cut: dict[int, str]) -> None:
    world.cut = cut

    async def play() -> None:
        async with connect() as client:
            await started(client)
            for step in range(5):
                await acted(client, step, "LEFT")

    asyncio.run(play())
    assert world.actions["e0"] == [1] * 5


def test_several_episodes_are_open_at_once(connect: Connect, world: World) -> None:
    async def play() -> None:
        async with connect(parallel=3) as client:
            await started(client)
            seen = await acted(client, 0, "LEFT", episode="e2")
            assert sorted(seen["open_episodes"]) == ["e0", "e1", "e2"]
            given_up = data_of(await client.call_tool("give_up", {"run": RUN, "episode": "e1", "reason": "lost"}))
            assert given_up["episode"] == {"id": "e1", "ended": True, "cause": "FORFEITED", "images": []}

    asyncio.run(play())
    assert world.actions["e2"] == [1]
    assert (world.causes, world.reasons) == ({"e1": types_pb2.CAUSE_FORFEITED}, {"e1": "lost"})


def test_images_are_sent_as_images(connect: Connect) -> None:
    async def play() -> list[tuple[str, tuple[int, int], str]]:
        async with connect() as client:
            await started(client, sensors=["rgb", "depth", "segmentation"])
            arguments = {"run": RUN, "images": ["rgb", "depth"], "image_format": "png", "image_size": 32}
            result = await client.call_tool("look", arguments)
            default = await client.call_tool("look", {"run": RUN})
        episode = data_of(result)["episode"]
        assert episode["images"] == ["rgb (png)", "depth (png)"]
        assert episode["depth"].startswith("far left: 1.0 m, left: open")
        assert episode["visible"] == ["dotted red mug, 16 degrees left, 1.0 m"]
        images = [block for block in (*result.content, *default.content) if isinstance(block, ImageContent)]
        opened = [Image.open(io.BytesIO(base64.b64decode(image.data))) for image in images]
        return [(i.mime_type, o.size, o.mode) for i, o in zip(images, opened, strict=True)]

    assert asyncio.run(play()) == [
        ("image/png", (32, 32), "RGB"),
        ("image/png", (32, 32), "L"),
        ("image/jpeg", (3, 2), "RGB"),
    ]


def test_runs_are_listed(connect: Connect) -> None:
    async def play() -> None:
        async with connect() as client:
            await started(client, agent_arguments={"prompt": 3})
            listed = data_of(await client.call_tool("runs", {"state": "running"}))
            assert [(run["id"], run["agent"], run["episodes_left"]) for run in listed["runs"]] == [(RUN, "mine", 4)]
            assert data_of(await client.call_tool("runs", {"state": "complete"})) == {"runs": [], "more": 0}

    asyncio.run(play())


@pytest.mark.parametrize(
    ("tool", "arguments", "message"),
    [
        ("start", {}, "wrong arguments: language: Field required; agent: Field required"),
        ("start", {"language": "xx", "agent": "a"}, "the server has no language 'xx'; it has en"),
        ("start", {"language": "en", "agent": "a", "split": "none"}, "the server has no split 'none'"),
        ("start", {"language": "en", "agent": "a", "sensors": ["oracle"]}, "sensors.0: Input should be 'rgb', 'depth'"),
        ("start", {"language": ["en"], "agent": "a"}, "language: Input should be a valid string, not ['en']"),
        ("start", {"language": "en", "agent": "a" * 10_000_000}, "agent: String should have at most 200 characters"),
        ("runs", {"limit": 0}, "limit: Input should be greater than or equal to 1, not 0"),
        ("look", {"run": "7"}, "'7' is not the id of a run, expected 32 hexadecimal digits"),
        ("look", {"run": OTHER}, f"there is no run '{OTHER}'"),
        ("look", {"run": "r" * 1_000_000}, "run: String should have at most 64 characters"),
        ("look", {"run": RUN, "episode": "x"}, "episode 'x' of run"),
        ("look", {"run": RUN, "images": ["depth"]}, "the run has no images of depth; its sensors are none"),
        ("look", {"run": RUN, "image_size": 5000}, "image_size: Input should be less than or equal to 1024, not 5000"),
        ("look", {"run": RUN, "size": 5}, "size: Extra inputs are not permitted, not 5"),
        ("act", {"run": RUN, "episode": "e0"}, "step: Field required; actions: Field required"),
        ("act", {"run": RUN, "episode": "e0", "step": "0", "actions": ["LEFT"]}, "step: Input should be a valid"),
        ("act", {"run": RUN, "episode": "e0", "step": True, "actions": ["LEFT"]}, "step: Input should be a valid"),
        ("act", {"run": RUN, "episode": "e0", "step": -1, "actions": ["LEFT"]}, "step: Input should be greater than"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": "LEFT"}, "actions: Input should be a valid list"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": []}, "actions: List should have at least 1 item"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": ["JUMP"]}, "actions.0: Input should be 'FORWARD'"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": ["LEFT"] * 1001}, "List should have at most 1000"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": ["LEFT"], "note": "ह" * 2000}, "a note has 6000"),
        ("act", {"run": RUN, "episode": "e0", "step": 2**70, "actions": ["LEFT"]}, "is ahead of the present step, 0"),
        ("act", {"run": RUN, "episode": "e9", "step": 0, "actions": ["LEFT"]}, "Open episodes: e0. Call `look`"),
        ("act", {"run": RUN, "episode": "e0", "step": 0, "actions": ["LEFT"], "images": ["rgb"]}, "no images of rgb"),
        ("give_up", {"run": RUN, "episode": ""}, "episode: String should have at least 1 character"),
        ("report", {"run": RUN}, "has scores when it is over, but only 0 of its 4 episodes have ended"),
    ],
)  # fmt: skip
def test_wrong_calls_have_clear_errors(
    connect: Connect, world: World, tool: str, arguments: dict[str, Any], message: str
) -> None:
    async def play() -> None:
        async with connect() as client:
            await started(client)
            error = await refused(client, tool, **arguments)
            assert message in error
            assert len(error) < 2000
            assert (await acted(client, 0, "LEFT"))["episode"]["step"] == 1

    asyncio.run(play())
    assert world.actions["e0"] == [1]


def test_unknown_tools_and_methods_are_protocol_errors(connect: Connect) -> None:
    async def play() -> None:
        async with connect() as client:
            with pytest.raises(MCPError, match="unknown tool 'jump', expected one of start, runs, look, act"):
                await client.call_tool("jump", {})
            with pytest.raises(MCPError, match="Method not found"):
                await client.list_prompts()

    asyncio.run(play())


def test_a_thousand_actions_are_a_plan(connect: Connect, world: World) -> None:
    async def play() -> None:
        async with connect() as client:
            await started(client)
            over = await acted(client, 0, *["LEFT"] * 1000)
            assert (over["taken"], over["stopped"]) == (5, "episode over")

    asyncio.run(play())
    assert world.actions["e0"] == [1] * 5


def test_a_server_that_was_away_is_found_again(connect: Connect, world: World) -> None:
    """After the patience is exhausted, the next call resumes the run."""

    async def play() -> None:
        async with connect(patience=0.2) as client:
            await started(client)
            await acted(client, 0, "LEFT")
            world.cut = dict.fromkeys(range(2, 30), "before")
            assert "the server was unreachable" in await refused(
                client, "act", run=RUN, episode="e0", step=1, actions=["LEFT"]
            )
            world.cut = {}
            assert (await acted(client, 1, "LEFT"))["episode"]["step"] == 2

    asyncio.run(play())
    assert world.actions["e0"] == [1, 1]
