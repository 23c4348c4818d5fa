"""The gRPC service Evaluation: converts between messages and the server's objects. `error_guard` handles errors."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import aclosing

import grpc

from arramon.v1 import PROTOCOL
from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationServicer
from arramon_server import __version__
from arramon_server.api.authentication import anonymous_caller, current_caller, is_on_same_machine
from arramon_server.api.encoding_choice import offered_encodings
from arramon_server.api.interceptor import CallOrigin
from arramon_server.api.messages import (
    account_message,
    breakdown_message,
    host_message,
    limits_message,
    receipt_message,
    report_message,
    run_message,
    split_message,
)
from arramon_server.api.play_stream import PlayHandler
from arramon_server.api.stream_limits import StreamLimits
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.run_notes import RunNotes
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.records import CodeReference, Run

_Context = grpc.aio.ServicerContext[object, object]

EPISODE_PAGE, MAX_EPISODE_PAGE = 1000, 10_000
"""Default and largest number of episodes on a page."""

OPEN_TIMEOUT_SECONDS = 20.0
"""Time within which a new stream must send its first message."""


class EvaluationService(EvaluationServicer):
    """Serves runs over gRPC.

    Args:
        runs: handles all calls about runs except Play and ListNotes.
        notes: lists the notes of runs.
        engine: plays the episodes.
        receipts: issues receipts of ended runs.
        config: the server's settings.
        threads: threads that compress images.
        stream_limits: counts the open streams.
    """

    def __init__(
        self,
        runs: RunService,
        notes: RunNotes,
        engine: Engine,
        receipts: Receipts,
        config: Config,
        threads: ImageThreads,
        stream_limits: StreamLimits,
    ) -> None:
        self._runs = runs
        self._notes = notes
        self._engine = engine
        self._receipts = receipts
        self._config = config
        self._stream_limits = stream_limits
        self._threads = threads

    async def GetServerInfo(self, request: pb.GetServerInfoRequest, context: _Context) -> pb.ServerInfo:
        is_local = is_on_same_machine(CallOrigin.of(context)) and not self._config.trust_proxy
        addresses = await asyncio.to_thread(self._runs.addresses) if is_local else []
        return pb.ServerInfo(
            version=__version__,
            protocol=PROTOCOL,
            splits=[split_message(split, self._runs.closing) for split in self._runs.splits.values()],
            encodings=offered_encodings(self._config.listen),
            image_sizes=self._config.image_sizes,
            limits=limits_message(self._runs.limits.steps_per_phase, self._runs.clocks),
            max_episodes_per_stream=self._config.max_episodes_per_stream,
            max_message_bytes=self._config.max_message_bytes,
            addresses=addresses,
            public_key=self._receipts.public_key,
            anonymous=anonymous_caller(self._config) is not None,
            host=host_message(self._config),
            note_bytes=self._config.note_bytes,
        )

    async def ListEpisodes(self, request: pb.ListEpisodesRequest, context: _Context) -> pb.ListEpisodesResponse:
        size, start = request.page_size or EPISODE_PAGE, request.page_token or "0"
        if not 1 <= size <= MAX_EPISODE_PAGE:
            raise BadInput(f"page_size is {size}, expected 1 to {MAX_EPISODE_PAGE}")
        if not (start.isascii() and start.isdigit() and len(start) < 10):
            raise BadInput(f"page_token is {start[:20]!r}, expected the next_page_token of the previous page")
        listed = self._runs.episodes(request.split, request.language)
        end = int(start) + size
        return pb.ListEpisodesResponse(
            episodes=[
                pb.ListedEpisode(episode_id=episode.episode_id, section=episode.section)
                for episode in listed[int(start) : end]
            ],
            next_page_token=str(end) if end < len(listed) else "",
        )

    async def CreateRun(self, request: pb.CreateRunRequest, context: _Context) -> pb.Run:
        caller = current_caller()

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
                    episode_ids=request.episode_ids,
                    agent_arguments=[(argument.name, argument.value) for argument in request.agent_arguments],
                    code=CodeReference(request.code.url, request.code.commit, request.code.image),
                )
            )

        return await asyncio.to_thread(create)

    async def GetRun(self, request: pb.GetRunRequest, context: _Context) -> pb.Run:
        caller = current_caller()
        return await asyncio.to_thread(lambda: run_message(*self._runs.progress_for(caller, request.run_id)))

    async def ListRuns(self, request: pb.ListRunsRequest, context: _Context) -> pb.ListRunsResponse:
        caller = current_caller()

        def page() -> pb.ListRunsResponse:
            size = request.page_size or 50
            runs = self._runs.runs_page(caller, size, request.page_token or None)
            token = runs[-1].run_id if len(runs) == size else ""
            progress = self._runs.progress_of([run.run_id for run in runs])
            messages = [run_message(run, progress[run.run_id]) for run in runs]
            return pb.ListRunsResponse(runs=messages, next_page_token=token)

        return await asyncio.to_thread(page)

    async def CancelRun(self, request: pb.CancelRunRequest, context: _Context) -> pb.Run:
        return self._message(await self._runs.cancel(current_caller(), request.run_id))

    async def GetReport(self, request: pb.GetReportRequest, context: _Context) -> pb.Report:
        caller = current_caller()
        return await asyncio.to_thread(lambda: report_message(self._runs.report(caller, request.run_id)))

    async def GetReceipt(self, request: pb.GetReceiptRequest, context: _Context) -> pb.Receipt:
        caller = current_caller()
        return await asyncio.to_thread(
            lambda: receipt_message(self._receipts.of(caller, request.run_id, request.number))
        )

    async def GetBreakdown(self, request: pb.GetBreakdownRequest, context: _Context) -> pb.Breakdown:
        caller = current_caller()
        return await asyncio.to_thread(lambda: breakdown_message(*self._runs.breakdown(caller, request.run_id)))

    async def ListNotes(self, request: pb.ListNotesRequest, context: _Context) -> pb.ListNotesResponse:
        caller = current_caller()

        def page() -> pb.ListNotesResponse:
            notes, token = self._notes.page(
                caller, request.run_id, request.episode_id, request.page_size, request.page_token
            )
            messages = [pb.Note(episode_id=note.episode_id, step=note.step, text=note.text) for note in notes]
            return pb.ListNotesResponse(notes=messages, next_page_token=token)

        return await asyncio.to_thread(page)

    async def GetAccount(self, request: pb.GetAccountRequest, context: _Context) -> pb.Account:
        caller = current_caller()

        def account() -> pb.Account:
            standings = {split: self._runs.quotas.limits_and_usage(caller, split) for split in self._runs.splits}
            return account_message(caller, standings)

        return await asyncio.to_thread(account)

    async def Play(  # type: ignore[override]  # its responses are serialized already, see `arramon_server.api.wire`
        self, request_iterator: AsyncIterator[pb.PlayRequest], context: _Context
    ) -> AsyncIterator[bytes]:
        first = await _first_message(request_iterator)
        if first is None or first.WhichOneof("message") != "open":
            raise BadInput("a stream's first message is `open`")
        caller = current_caller()
        handler = PlayHandler(first.open, caller, self._runs, self._engine, self._config, self._threads)
        async with (
            self._stream_limits.count(caller, handler.stream.run, handler.stream.player),
            aclosing(handler.serve(request_iterator)) as responses,
        ):
            async for response in responses:
                yield response

    def _message(self, run: Run) -> pb.Run:
        return run_message(run, self._runs.progress(run.run_id))


async def _first_message(requests: AsyncIterator[pb.PlayRequest]) -> pb.PlayRequest | None:
    """Return a stream's first message; None if the stream ends before it.

    Raises:
        BadInput: if none arrives in time, as a silent stream uses as many resources as one that plays.
    """
    try:
        async with asyncio.timeout(OPEN_TIMEOUT_SECONDS):
            return await anext(requests, None)
    except TimeoutError:
        raise BadInput(
            f"the stream sent no message within {OPEN_TIMEOUT_SECONDS:.0f} seconds; expected `open`"
        ) from None
