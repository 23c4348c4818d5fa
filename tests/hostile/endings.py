"""Clients that end many streams at once, in every way in which a client can end them.

As a program, `python -m tests.hostile.endings ADDRESS RUN WAY PLAYER...`, it is a client that can be killed.
"""

import asyncio
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests.serving import METADATA

DEADLINE = 0.3
"""Seconds for which the first of the streams with a deadline may last; each of the others a little longer."""

OPTIONS = [("grpc.use_local_subchannel_pool", 1), ("grpc.http2.bdp_probe", 0)]
"""A connection of their own, whose window does not grow: what is not read stays with the server."""


@asynccontextmanager
async def streams(
    address: str, run_id: str, players: Sequence[str], timeouts: Sequence[float | None]
) -> AsyncIterator[list[Any]]:
    """A stream for each player, on one connection of their own; all of them have an episode of the run.

    The first half read nothing: their images are larger than what gRPC takes before it is read, so that the server is
    still writing. The second half, opened later, have answered an observation, and read the next.
    """
    async with grpc.aio.insecure_channel(address, options=OPTIONS) as channel:
        stub: Any = EvaluationStub(channel)
        calls = []
        for player, timeout in zip(players, timeouts, strict=True):
            call = stub.Play(metadata=METADATA, timeout=timeout)
            with suppress(grpc.RpcError, asyncio.InvalidStateError):  # its deadline may be over before it has begun
                await call.write(pb.PlayRequest(open=_opening(run_id, player)))
            calls.append(call)
        if None in timeouts:
            await asyncio.gather(*map(_act, calls[len(calls) // 2 :]))
        yield calls


async def end(address: str, run_id: str, ending: str, players: Sequence[str]) -> None:
    """Opens a stream for each player, and ends it in a way of `ENDINGS`, or waits to be killed."""
    has_deadline = ending == "deadline"
    timeouts = [DEADLINE + number / 200 if has_deadline else None for number in range(len(players))]
    async with streams(address, run_id, players, timeouts) as calls:
        if ending == "kill":
            sys.stdout.write("open\n")
            sys.stdout.flush()
            await asyncio.sleep(600)
        if ending == "close":
            return
        for call in calls:
            if ending == "cancel":
                call.cancel()
            elif ending == "half-close":
                await call.done_writing()
                await _drain(call)
        codes = {await call.code() for call in calls}
        assert codes == {ENDINGS[ending]}, codes


ENDINGS = {
    "cancel": grpc.StatusCode.CANCELLED,
    "deadline": grpc.StatusCode.DEADLINE_EXCEEDED,
    "half-close": grpc.StatusCode.OK,
    "close": None,
    "kill": None,
}
"""How a client can end its streams, and the status that it sees where it sees one."""


def _opening(run_id: str, player: str) -> pb.Open:
    raw = types_pb2.ENCODING_RAW
    return pb.Open(run_id=run_id, player=player, max_episodes=1, adopt=True, encoding=raw, image_size=224)


async def _act(call: Any) -> None:
    """Answers the first observation, and reads up to the second."""
    while (response := await call.read()) is not grpc.aio.EOF:
        for event in response.events:
            if event.HasField("observation") and event.observation.step:
                return
            if event.HasField("observation"):
                act = pb.Act(episode_id=event.observation.episode_id, step=0, action=types_pb2.ACTION_LEFT)
                await call.write(pb.PlayRequest(actions=pb.ActionBatch(acts=[act])))


async def _drain(call: Any) -> None:
    while await call.read() is not grpc.aio.EOF:
        pass


if __name__ == "__main__":
    asyncio.run(end(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]))
