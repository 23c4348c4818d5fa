"""The Evaluation service: translate, call, translate. `server.api.guard` turns errors into statuses."""

import asyncio
from collections.abc import AsyncIterator

import grpc

from arramon.v1 import PROTOCOL
from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationServicer
from server import __version__
from server.api.authentication import anonymous_caller, caller_of, is_near
from server.api.counting import Counting
from server.api.messages import (
    account_message,
    limits_message,
    receipt_message,
    report_message,
    run_message,
    split_message,
)
from server.api.playing import Playing
from server.api.sharing import offered
from server.config import Config
from server.errors import BadInput
from server.runs.engine import Engine
from server.runs.receipts import Receipts
from server.runs.records import Run
from server.runs.service import Runs

_Context = grpc.aio.ServicerContext[object, object]

OPENING_SECONDS = 20.0
"""How long a new stream may take to say what it wants."""


class Servicer(EvaluationServicer):
    """Serves runs over gRPC.

    Args:
        runs: all but playing.
        engine: playing.
        receipts: of what was played.
        config: what the server allows.
    """

    def __init__(self, runs: Runs, engine: Engine, receipts: Receipts, config: Config) -> None:
        self._runs = runs
        self._engine = engine
        self._receipts = receipts
        self._config = config
        self._counting = Counting(runs.quotas, engine.worker)

    async def GetServerInfo(self, request: pb.GetServerInfoRequest, context: _Context) -> pb.ServerInfo:
        near = is_near(context) and not self._config.trust_proxy
        addresses = await asyncio.to_thread(self._runs.addresses) if near else []
        return pb.ServerInfo(
            version=__version__,
            protocol=PROTOCOL,
            splits=map(split_message, self._runs.splits.values()),
            encodings=offered(self._config.listen),
            image_sizes=self._config.image_sizes,
            limits=limits_message(self._runs.limits.steps_per_phase, self._runs.clocks),
            max_episodes_per_stream=self._config.max_episodes_per_stream,
            max_message_bytes=self._config.max_message_bytes,
            addresses=addresses,
            public_key=self._receipts.public_key,
            anonymous=anonymous_caller(self._config) is not None,
        )

    async def CreateRun(self, request: pb.CreateRunRequest, context: _Context) -> pb.Run:
        caller = caller_of(context)

        def create() -> pb.Run:
            return self._message(
                self._runs.create(
                    caller,
                    participant=request.participant,
                    agent=request.agent,
                    split=request.split,
                    language=request.language,
                    sensors=request.sensors,
                    episodes=request.episodes,
                )
            )

        return await asyncio.to_thread(create)

    async def GetRun(self, request: pb.GetRunRequest, context: _Context) -> pb.Run:
        caller = caller_of(context)
        return await asyncio.to_thread(lambda: self._message(self._runs.visible(caller, request.run_id)))

    async def ListRuns(self, request: pb.ListRunsRequest, context: _Context) -> pb.ListRunsResponse:
        caller = caller_of(context)

        def page() -> pb.ListRunsResponse:
            size = request.page_size or 50
            runs = self._runs.page(caller, size, request.page_token or None)
            token = runs[-1].run_id if len(runs) == size else ""
            return pb.ListRunsResponse(runs=map(self._message, runs), next_page_token=token)

        return await asyncio.to_thread(page)

    async def CancelRun(self, request: pb.CancelRunRequest, context: _Context) -> pb.Run:
        return self._message(await self._runs.cancel(caller_of(context), request.run_id))

    async def GetReport(self, request: pb.GetReportRequest, context: _Context) -> pb.Report:
        caller = caller_of(context)
        return await asyncio.to_thread(lambda: report_message(self._runs.report(caller, request.run_id)))

    async def GetReceipt(self, request: pb.GetReceiptRequest, context: _Context) -> pb.Receipt:
        caller = caller_of(context)
        return await asyncio.to_thread(lambda: receipt_message(self._receipts.of(caller, request.run_id)))

    async def GetAccount(self, request: pb.GetAccountRequest, context: _Context) -> pb.Account:
        caller = caller_of(context)

        def account() -> pb.Account:
            standings = {split: self._runs.quotas.standing(caller, split) for split in self._runs.splits}
            return account_message(caller, standings)

        return await asyncio.to_thread(account)

    async def Play(
        self, request_iterator: AsyncIterator[pb.PlayRequest], context: _Context
    ) -> AsyncIterator[pb.PlayResponse]:
        first = await _first(request_iterator)
        if first is None or first.WhichOneof("message") != "open":
            raise BadInput("a stream's first message is `open`")
        caller = caller_of(context)
        playing = Playing(first.open, caller, self._runs, self._engine, self._config)
        async with self._counting.counted(caller, playing.stream.run, playing.stream.player):
            async for response in playing.serve(request_iterator):
                yield response

    def _message(self, run: Run) -> pb.Run:
        return run_message(run, self._runs.progress(run.run_id))


async def _first(requests: AsyncIterator[pb.PlayRequest]) -> pb.PlayRequest | None:
    """A stream's first message; None where it ends before one.

    Raises:
        BadInput: if none comes in time: a stream that says nothing costs the server as much as one that plays.
    """
    try:
        async with asyncio.timeout(OPENING_SECONDS):
            return await anext(requests, None)
    except TimeoutError:
        raise BadInput(f"no message came on the stream in {OPENING_SECONDS:.0f} seconds; expected `open`") from None
