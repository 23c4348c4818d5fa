"""Players by the client of the package `mcp`, which repeat every call whose answer is lost."""

import asyncio
import json
import random
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack, suppress
from typing import Any, Self

import httpx2
from mcp import Client, MCPError
from mcp.types import CallToolResult, TextContent

from arramon_client.world import Action

CONNECTION_ERRORS = (MCPError, OSError, httpx2.HTTPError, ExceptionGroup, TimeoutError)
"""What a call raises when the server or the connection is gone; results of tools are no exceptions."""

ATTEMPTS = 100


def rule(episode_id: str, step: int) -> int:
    """Return the action at a step, the same in every play."""
    return random.Random(f"{episode_id}/{step}").choice((0, 0, 0, 1, 2, 3))


def plan(episode_id: str, step: int) -> list[int]:
    """Return one to three actions for a step, the same in every play."""
    count = random.Random(f"{episode_id}+{step}").randint(1, 3)
    return [rule(episode_id, step + number) for number in range(count)]


class Player:
    """A player that connects, and connects again when the server is gone.

    Args:
        connect: returns a new client, not entered yet.

    Attributes:
        acts: recorded actions by episode, as this client counts them.
        repeated: number of calls that were repeated.
        answered: number of acts that were answered.
        unanswered: actions of the last acts of episodes whose answer was lost, which may have been taken.
    """

    def __init__(self, connect: Callable[[], Client]) -> None:
        self._connect = connect
        self._client: Client | None = None
        self._stack = AsyncExitStack()
        self.acts: dict[str, list[int]] = {}
        self.repeated = 0
        self.answered = 0
        self.unanswered: dict[str, list[int]] = {}

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._leave()

    async def call(self, name: str, **arguments: Any) -> CallToolResult:
        """Call a tool until it is answered."""
        for _ in range(ATTEMPTS):
            try:
                if self._client is None:
                    self._client = await self._stack.enter_async_context(self._connect())
                return await self._client.call_tool(name, arguments)
            except (asyncio.CancelledError, *CONNECTION_ERRORS) as error:
                await self._leave(error)
                self.repeated += 1
                await asyncio.sleep(0.05)
        raise AssertionError(f"{name} was not answered in {ATTEMPTS} attempts")

    async def data(self, name: str, **arguments: Any) -> dict[str, Any]:
        """Call a tool until it is answered; return its structured result."""
        return data_of(await self.call(name, **arguments))

    async def play(self, run: str, before_act: Callable[[], Awaitable[None]] | None = None) -> None:
        """Play a run to its end."""
        while (looked := await self.data("look", run=run, images=[]))["run"]["state"] == "running":
            seen: dict[str, Any] | None = looked
            while seen is not None and "episode" in seen and not seen["episode"]["ended"]:
                if before_act is not None:
                    await before_act()
                seen = await self._act(run, seen["episode"]["id"], seen["episode"]["step"])

    async def _act(self, run: str, episode_id: str, step: int) -> dict[str, Any] | None:
        actions = plan(episode_id, step)
        recorded = self.acts.setdefault(episode_id, [])
        assert step == len(recorded), "the server has taken more or fewer steps than were answered"
        names = [Action(action).name for action in actions]
        before = self.repeated
        result = await self.call("act", run=run, episode=episode_id, step=step, actions=names, images=[])
        self.answered += 1
        if result.is_error:  # The episode ended, and the answer that said so was lost.
            assert self.repeated > before, result.content
            assert "is not open: it has ended" in text_of(result)
            self.unanswered[episode_id] = actions
            return None
        seen = data_of(result)
        recorded += actions[: seen["taken"]]
        if seen["episode"]["ended"] and seen["episode"]["cause"] == "UNKNOWN":
            self.unanswered[episode_id] = actions[seen["taken"] :]
        return seen

    async def _leave(self, error: BaseException | None = None) -> None:
        """Close the connection; an error that ended it, which can be the cancellation of a call, goes no further."""
        self._client = None
        stack, self._stack = self._stack, AsyncExitStack()
        is_own: bool | None = True
        with suppress(*CONNECTION_ERRORS):
            is_own = await stack.__aexit__(type(error) if error else None, error, None)
        if isinstance(error, asyncio.CancelledError) and not is_own:
            raise error


def text_of(result: CallToolResult) -> str:
    """Return the text of a result."""
    first = result.content[0]
    assert isinstance(first, TextContent)
    return first.text


def data_of(result: CallToolResult) -> dict[str, Any]:
    """Return the structured result of a call that succeeded; its text repeats it."""
    assert not result.is_error, text_of(result)
    data: dict[str, Any] = result.structured_content
    assert json.loads(text_of(result)) == data
    return data
