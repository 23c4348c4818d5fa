"""The gRPC service Leaderboard: converts between messages and the board. `error_guard` turns errors into statuses."""

import asyncio
from dataclasses import asdict
from typing import Any, TypeAlias

import grpc

from arramon.v1 import evaluation_pb2
from arramon.v1 import leaderboard_pb2 as pb
from arramon.v1.leaderboard_pb2_grpc import LeaderboardServicer
from arramon_server.api.authentication import current_caller
from arramon_server.api.messages import row_message, run_message, score_message, time_message
from arramon_server.board.board import Board, RunComparisons
from arramon_server.board.cost import Cost
from arramon_server.board.epoch_board import Epoch, EpochBoard, EpochChanges
from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.publisher import Publisher
from arramon_server.board.reproductions import Reproduction
from arramon_server.board.standings import BOTH, HEADLINE, Entry, Mark, PaperResult, Standing
from arramon_server.errors import BadInput
from arramon_server.runs.storage.corrections import Correction
from arramon_server.scoring.aggregate import Interval

PAGE_SIZE, MAX_PAGE_SIZE = 100, 1000
"""Default and maximum number of standings on a page."""

_Context: TypeAlias = grpc.aio.ServicerContext[Any, Any]

_MARKS = {mark: pb.Mark.Value(f"MARK_{mark.name}") for mark in Mark}
_WRITERS = {pb.ExportRequest.FORMAT_CSV: as_csv, pb.ExportRequest.FORMAT_JSON: as_json}


class LeaderboardService(LeaderboardServicer):
    """Serves the leaderboard over gRPC.

    Args:
        board: the standings.
        publisher: publishes and withdraws runs.
        epochs: the epochs of hidden splits.
    """

    def __init__(self, board: Board, publisher: Publisher, epochs: EpochBoard) -> None:
        self._board = board
        self._publisher = publisher
        self._epochs = epochs

    async def Publish(self, request: pb.PublishRequest, context: _Context) -> pb.Entry:
        caller = current_caller()

        def publish() -> pb.Entry:
            reproduces = request.reproduces if request.HasField("reproduces") else None
            cost = read_cost(request.cost) if request.HasField("cost") else None
            self._publisher.publish(caller, request.run_id, request.note, cost, reproduces)
            return self._entry(request.run_id)

        return await asyncio.to_thread(publish)

    async def Withdraw(self, request: pb.WithdrawRequest, context: _Context) -> pb.WithdrawResponse:
        await asyncio.to_thread(self._publisher.withdraw, current_caller(), request.run_id)
        return pb.WithdrawResponse()

    async def List(self, request: pb.ListRequest, context: _Context) -> pb.ListResponse:
        return await asyncio.to_thread(self._page, request)

    async def GetEntry(self, request: pb.GetEntryRequest, context: _Context) -> pb.Entry:
        return await asyncio.to_thread(self._entry, request.run_id)

    async def Compare(self, request: pb.CompareRequest, context: _Context) -> pb.CompareResponse:
        def compare() -> pb.CompareResponse:
            return comparisons_message(
                self._board.compare_with_all(request.run_id, request.language, request.sort or HEADLINE)
            )

        return await asyncio.to_thread(compare)

    async def Export(self, request: pb.ExportRequest, context: _Context) -> pb.ExportResponse:
        if request.format not in _WRITERS:
            raise BadInput("the export has no format; expected FORMAT_CSV or FORMAT_JSON")

        def export() -> str:
            listing = self._board.listing(request.split, request.language or BOTH, request.sort or HEADLINE)
            return _WRITERS[request.format](listing)

        return pb.ExportResponse(content=await asyncio.to_thread(export))

    async def GetActions(self, request: pb.GetActionsRequest, context: _Context) -> pb.Actions:
        actions = await asyncio.to_thread(self._epochs.actions, request.run_id)
        return pb.Actions(run_id=request.run_id, episodes=actions)

    async def ListEpochs(self, request: pb.ListEpochsRequest, context: _Context) -> pb.ListEpochsResponse:
        return pb.ListEpochsResponse(epochs=map(epoch_message, await asyncio.to_thread(self._epochs.all)))

    async def CompareEpochs(self, request: pb.CompareEpochsRequest, context: _Context) -> pb.CompareEpochsResponse:
        def compare() -> pb.CompareEpochsResponse:
            metric = request.sort or HEADLINE
            found = self._epochs.compare(request.older, request.newer, request.language, metric)
            return epoch_changes_message(found, metric)

        return await asyncio.to_thread(compare)

    def _entry(self, run_id: str) -> pb.Entry:
        message = entry_message(self._board.entry(run_id))
        message.reproductions.extend(map(reproduction_message, self._board.reproductions(run_id)))
        return message

    def _page(self, request: pb.ListRequest) -> pb.ListResponse:
        size, start = request.page_size or PAGE_SIZE, request.page_token or "0"
        if size > MAX_PAGE_SIZE:
            raise BadInput(f"page_size is {size}, expected 1 to {MAX_PAGE_SIZE}")
        if not (start.isascii() and start.isdecimal() and len(start) < 10):
            raise BadInput(f"page_token is {start[:20]!r}, expected the next_page_token of the previous page")
        listing = self._board.listing(request.split, request.language or BOTH, request.sort or HEADLINE)
        first, total = int(start), len(listing.standings)
        return pb.ListResponse(
            standings=map(standing_message, listing.standings[first : first + size]),
            references=map(reference_message, listing.references if first == 0 else ()),
            sort=listing.sort,
            total=total,
            next_page_token=str(first + size) if first + size < total else "",
            corrections=map(correction_message, listing.corrections if first == 0 else ()),
            closes_at=time_message(self._board.closing.of(request.split)),
            frozen=listing.frozen,
        )


def entry_message(entry: Entry, *, listed: bool = False) -> pb.Entry:
    """Return the message for a published run; without rows if it is `listed`, because its standing has them."""
    fingerprint = entry.receipt_fingerprint
    return pb.Entry(
        run=_public_run(entry),
        signature=entry.signature,
        rows=[] if listed else [row_message(name, metrics) for name, metrics in entry.rows.items()],
        published_at=entry.published_at.isoformat(timespec="seconds"),
        note=entry.note,
        coverage=entry.coverage,
        marks=[_MARKS[mark] for mark in entry.marks],
        receipt_digest=fingerprint.digest if fingerprint else b"",
        public_key=fingerprint.public_key if fingerprint else b"",
        runs_begun=entry.attempts.begun,
        runs_published=entry.attempts.published,
        reproduced_by=len(entry.reproducers),
        reproduces=entry.reproduces or "",
        cost=cost_message(entry.cost) if entry.cost else None,
        voided=entry.voided,
        corrections=map(correction_message, entry.corrections),
        superseded=[
            pb.SupersededReceipt(number=one.number, superseded_at=time_message(one.superseded_at), digest=one.digest)
            for one in (fingerprint.superseded if fingerprint else ())
        ],
        frozen=entry.frozen,
    )


def correction_message(correction: Correction) -> pb.Correction:
    """Return the message for a correction of a split by its host."""
    return pb.Correction(
        kind=pb.CorrectionKind.Value(f"CORRECTION_KIND_{correction.kind.name}"),
        made_at=time_message(correction.made_at),
        reason=correction.reason,
        episodes=correction.episodes,
        data_before=correction.data_before or "",
        data_after=correction.data_after or "",
    )


def cost_message(cost: Cost) -> pb.Cost:
    """Return the message for a declared cost."""
    return pb.Cost(parameters=cost.parameters, tokens=cost.tokens, price=cost.price)


def read_cost(message: pb.Cost) -> Cost:
    """Return the declared cost in a message."""
    return Cost(
        message.parameters if message.HasField("parameters") else None,
        message.tokens if message.HasField("tokens") else None,
        message.price if message.HasField("price") else None,
    )


def _public_run(entry: Entry) -> evaluation_pb2.Run:
    run = run_message(entry.run, entry.progress)
    run.participant, run.agent, run.published = entry.participant, entry.agent, True
    run.ClearField("bank_seconds_left")
    return run


def reproduction_message(reproduction: Reproduction) -> pb.Reproduction:
    """Return the message for a published reproduction of a run."""
    entry = reproduction.entry
    return pb.Reproduction(
        run=_public_run(entry),
        published_at=entry.published_at.isoformat(timespec="seconds"),
        differences=row_message("", reproduction.differences).scores,
    )


def epoch_message(epoch: Epoch) -> pb.Epoch:
    """Return the message for an epoch of a hidden split."""
    record = epoch.record
    return pb.Epoch(
        split=record.split,
        state=pb.EpochState.Value(f"EPOCH_STATE_{record.state.name}"),
        statement=record.statement,
        commitment=record.commitment,
        secret=record.secret or "",
        command=epoch.command,
        **epoch.times,
    )


def epoch_changes_message(changes: EpochChanges, metric: str) -> pb.CompareEpochsResponse:
    """Return the message for the comparison of two epochs."""
    lines = [
        pb.EpochComparison(
            older=standing_message(line.older, brief=True),
            newer=standing_message(line.newer, brief=True),
            older_mean=line.older_mean,
            newer_mean=line.newer_mean,
            difference=score_message(metric, line.difference),
            against_others=score_message(metric, line.against_others) if line.against_others else None,
            same_code=line.same_code,
        )
        for line in changes.agents
    ]
    mean = score_message(metric, changes.mean) if changes.mean else None
    return pb.CompareEpochsResponse(agents=lines, mean=mean, sort=metric)


def comparisons_message(found: RunComparisons) -> pb.CompareResponse:
    """Return the message for a standing compared with all others of its list."""
    comparisons = [
        pb.Comparison(
            other=standing_message(other, brief=True),
            difference=compared.difference.mean,
            low=compared.difference.low,
            high=compared.difference.high,
            p=compared.difference.p,
            corrected_p=compared.corrected,
            shown=compared.shown,
        )
        for other, compared in found.lines
    ]
    return pb.CompareResponse(
        standing=standing_message(found.standing), comparisons=comparisons, sort=found.listing.sort
    )


def standing_message(standing: Standing, *, brief: bool = False) -> pb.Standing:
    """Return the message for a standing, a line of the leaderboard; without rows if it is `brief`."""
    return pb.Standing(
        rank=standing.rank,
        tied=standing.tied,
        participant=standing.participant,
        agent=standing.agent,
        sensors=standing.sensors,
        coverage=standing.coverage,
        marks=[_MARKS[mark] for mark in standing.marks],
        rows=[] if brief else [row_message(name, metrics) for name, metrics in standing.rows.items()],
        entries=[entry_message(entry, listed=True) for entry in standing.entries],
        last_rank=standing.last_rank,
        runs_begun=standing.attempts.begun,
        runs_published=standing.attempts.published,
        reproduced_by=standing.reproduced_by,
        gap=pb.LanguageGap(**asdict(standing.gap)) if standing.gap else None,
        spread=pb.SeedSpread(**asdict(standing.spread)) if standing.spread else None,
    )


def reference_message(reference: PaperResult) -> pb.Reference:
    """Return the message for a line of the paper's tables."""
    rows = [
        row_message(name, {metric: Interval(value, value, value) for metric, value in values.items()})
        for name, values in reference.rows.items()
    ]
    return pb.Reference(
        name=reference.name,
        short=reference.short,
        split=reference.split,
        language=reference.language,
        source=reference.source,
        note=reference.note,
        rows=rows,
    )
