"""Limits on the open calls of each group of callers, so that no group can exhaust the server's calls."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import aclosing
from dataclasses import dataclass
from typing import Any, cast

import grpc

from arramon_server.api.authentication import current_caller
from arramon_server.api.interceptor import Context, Continuation, Handler, HandlerFunction, wrap_handler
from arramon_server.errors import OverQuota
from arramon_server.runs.accounts.callers import ANONYMOUS, Role


@dataclass(frozen=True, slots=True)
class CallerGroup:
    """A group of callers that share a limit.

    Attributes:
        name: a participant, or a kind of anonymous callers; completes "too many open calls from".
        share: divisor of the process's limit: the group may have 1/share of it open.
        at_once: maximum number of unary calls that are handled concurrently; further ones wait.
    """

    name: str
    share: int
    at_once: int


WITHOUT_TOKEN = CallerGroup("clients without a token", 4, 4)
WATCHERS = CallerGroup("health and reflection streams", 16, 1024)
PROBES = CallerGroup("health probes", 16, 1024)
PARTICIPANT_SHARE, PARTICIPANT_AT_ONCE = 4, 2


class CallLimits(grpc.aio.ServerInterceptor):
    """Interceptor that limits the open calls of each group of callers. It must come after `Authentication`.

    A call counts until gRPC has ended it too, because a client may leave the response unread. Hosts, and anonymous
    players on their own machine, are not limited.

    Args:
        max_calls: maximum number of open calls of the process.
    """

    def __init__(self, max_calls: int) -> None:
        self._max_calls = max_calls
        self._open: Counter[CallerGroup] = Counter()
        self._slots: dict[CallerGroup, asyncio.Semaphore] = {}

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Wrap the call's handler so that it counts the call first."""
        handler = await continuation(handler_call_details)
        if handler is None:
            return None
        method, streaming = handler_call_details.method, handler.response_streaming

        async def answer(work: HandlerFunction, request: Any, context: Context) -> Any:
            group = _group_of(method, streaming=streaming)
            if group is None:
                return await work(request, context)
            self._enter(group, context)
            async with self._slots[group]:
                return await work(request, context)

        async def stream(work: HandlerFunction, request: Any, context: Context) -> AsyncIterator[Any]:
            group = _group_of(method, streaming=streaming)
            if group is not None:
                self._enter(group, context)
            async with aclosing(work(request, context)) as responses:
                async for response in responses:
                    yield response

        return wrap_handler(handler, answer, stream)

    def _enter(self, group: CallerGroup, context: Context) -> None:
        """Count a call as open until it ends.

        Raises:
            OverQuota: if the group has reached its limit of open calls.
        """
        limit = max(1, self._max_calls // group.share)
        if self._open[group] >= limit:
            raise OverQuota(f"too many open calls from {group.name}: {limit} are allowed; try again when one has ended")
        self._open[group] += 1
        self._slots.setdefault(group, asyncio.Semaphore(group.at_once))

        def leave(_: Any) -> None:
            self._open[group] -= 1
            if not self._open[group]:
                del self._open[group], self._slots[group]

        context.add_done_callback(cast(Any, leave))


def _group_of(method: str, *, streaming: bool) -> CallerGroup | None:
    """Return the group that a call belongs to; None if it is not limited."""
    if not method.startswith("/arramon."):
        return WATCHERS if streaming else PROBES
    caller = current_caller()
    if caller.role is Role.HOST or caller == ANONYMOUS:
        return None
    if caller.account is None:
        return WITHOUT_TOKEN
    return CallerGroup(f"participant {caller.account}", PARTICIPANT_SHARE, PARTICIPANT_AT_ONCE)
