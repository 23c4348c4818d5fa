"""Keeps a place for everybody: nobody holds more than a share of the open calls, or has many answered at once."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any, cast

import grpc

from server.api.authentication import caller_of
from server.api.wrapping import Context, Continuation, Handler, Work, wrapped
from server.errors import OverQuota
from server.runs.callers import ANONYMOUS, Role


@dataclass(frozen=True, slots=True)
class Crowd:
    """Callers who share their places.

    Attributes:
        name: of one participant, or of all whom nothing tells apart.
        share: of the calls that a process has open at once, which is one in so many.
        at_once: calls with one answer that are worked at together; the others wait for their turn.
    """

    name: str
    share: int
    at_once: int


STRANGERS = Crowd("those without a token together", 4, 4)
WATCHERS = Crowd("all watchers of health and reflection together", 16, 1024)
PROBES = Crowd("all probes together", 16, 1024)
PARTICIPANT_SHARE, PARTICIPANT_AT_ONCE = 4, 2


class Crowding(grpc.aio.ServerInterceptor):
    """Counts the open calls of each crowd until they have ended for gRPC, too: a client may not read its answer.

    The host's own, and who plays alone on their own machine, are not held back. To be put behind `Authentication`.

    Args:
        max_calls: that the process has open at once.
    """

    def __init__(self, max_calls: int) -> None:
        self._max_calls = max_calls
        self._open: Counter[Crowd] = Counter()
        self._turns: dict[Crowd, asyncio.Semaphore] = {}

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Puts the count before the method's own work."""
        handler = await continuation(handler_call_details)
        if handler is None:
            return None
        method, streaming = handler_call_details.method, handler.response_streaming

        async def answer(work: Work, request: Any, context: Context) -> Any:
            crowd = _crowd(method, context, streaming=streaming)
            if crowd is None:
                return await work(request, context)
            self._enter(crowd, context)
            async with self._turns[crowd]:
                return await work(request, context)

        async def stream(work: Work, request: Any, context: Context) -> AsyncIterator[Any]:
            crowd = _crowd(method, context, streaming=streaming)
            if crowd is not None:
                self._enter(crowd, context)
            async for response in work(request, context):
                yield response

        return wrapped(handler, answer, stream)

    def _enter(self, crowd: Crowd, context: Context) -> None:
        """Counts a call in, and out at its end.

        Raises:
            OverQuota: if the crowd has its share.
        """
        most = max(1, self._max_calls // crowd.share)
        if self._open[crowd] >= most:
            raise OverQuota(
                f"{crowd.name} have {most} calls open, and no more are allowed: try again when one has ended"
            )
        self._open[crowd] += 1
        self._turns.setdefault(crowd, asyncio.Semaphore(crowd.at_once))

        def leave(_: Any) -> None:
            self._open[crowd] -= 1
            if not self._open[crowd]:
                del self._open[crowd], self._turns[crowd]

        context.add_done_callback(cast(Any, leave))


def _crowd(method: str, context: Context, *, streaming: bool) -> Crowd | None:
    """To whom a call belongs; None where it is not counted."""
    if not method.startswith("/arramon."):
        return WATCHERS if streaming else PROBES
    caller = caller_of(context)
    if caller.role is Role.HOST or caller == ANONYMOUS:
        return None
    if caller.account is None:
        return STRANGERS
    return Crowd(f"you, {caller.account},", PARTICIPANT_SHARE, PARTICIPANT_AT_ONCE)
