"""Creates and connects the parts of a server process. `arramon_server.process.lifecycle` starts and stops them."""

from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass

import grpc
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_health.v1.health import aio as health
from grpc_reflection.v1alpha import reflection

from arramon.v1 import evaluation_pb2, leaderboard_pb2
from arramon.v1.evaluation_pb2_grpc import add_EvaluationServicer_to_server
from arramon.v1.leaderboard_pb2_grpc import add_LeaderboardServicer_to_server
from arramon_server.api.access_log import AccessLog
from arramon_server.api.authentication import Authentication
from arramon_server.api.call_limits import CallLimits
from arramon_server.api.error_guard import ErrorGuard
from arramon_server.api.evaluation import EvaluationService
from arramon_server.api.leaderboard import LeaderboardService
from arramon_server.api.response_writer import ResponseWriter
from arramon_server.api.stream_limits import StreamLimits
from arramon_server.api.version_check import VersionCheck
from arramon_server.board.board import Board
from arramon_server.board.entries import Entries
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.publisher import Publisher
from arramon_server.closing_times import ClosingTimes
from arramon_server.configuration.config import Config
from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput
from arramon_server.image_threads import ImageThreads
from arramon_server.process.prometheus_metrics import PrometheusMetrics
from arramon_server.process.readiness import Readiness
from arramon_server.process.tls import grpc_credentials
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.quotas import DefaultQuotas, Quotas
from arramon_server.runs.accounts.watch_passes import WatchPasses
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.run_notes import RunNotes
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.epoch_store import EpochStore
from arramon_server.runs.storage.metered_journal import MeteredJournal
from arramon_server.runs.storage.run_activity import RunActivity
from arramon_server.runs.storage.run_counts import runs_by_state

SERVICES = (
    evaluation_pb2.DESCRIPTOR.services_by_name["Evaluation"].full_name,
    leaderboard_pb2.DESCRIPTOR.services_by_name["Leaderboard"].full_name,
)
"""Full names of this project's gRPC services."""

CALLS_PER_CONNECTION = 256
"""Maximum number of open calls on one connection; a client holds back further ones. Reset calls count until gRPC has
cleared them away: without this limit, a flood of reset calls costs more than ten times as much."""


@dataclass(frozen=True)
class ServerParts:
    """The parts of a server process.

    Attributes:
        server: the gRPC server.
        address: address of the gRPC server.
        engine: plays the episodes.
        readiness: reports to the health service and the metrics.
        web: context that serves probes, metrics and pages while entered, and yields their URLs.
    """

    server: grpc.aio.Server
    address: str
    engine: Engine
    readiness: Readiness
    web: AbstractAsyncContextManager[dict[str, str]]


def create_parts(config: Config, splits: Mapping[str, Split], database: Database) -> ServerParts:
    """Create all parts of a process, without starting any.

    Raises:
        ArraMonError: if a file or the journal cannot be used, or an address cannot be listened on.
    """
    # Only the engine, and parts of the pages that play further splits, find these: no run on them can be created, seen,
    # published or scored by anybody else.
    played_splits = SplitLookup(splits)
    metrics = PrometheusMetrics(config.camera, lambda: runs_by_state(database))
    journal, accounts = MeteredJournal(database, metrics), Accounts(database)
    authentication = Authentication(accounts, config)
    server = _server(config, authentication, metrics)
    address = _bind(server, config.listen, grpc_credentials(config))
    # gRPC allows renewable credentials for one address only, so each address has credentials of its own.
    own_address = _bind(server, config.own_address, grpc_credentials(config)) if config.own_address else address
    threads = ImageThreads()
    engine = Engine(
        played_splits,
        journal,
        RunActivity(database, close_unplayed=not config.is_for_own_machine),
        camera=config.camera,
        threads=threads,
        address=own_address if config.shared_port else "",
        meter=metrics,
        note_limits=config.note_limits,
    )
    quotas = Quotas(database, DefaultQuotas(config, [split.name for split in splits.values() if split.hidden]))
    closing = ClosingTimes(config.closes, config.frozen)
    runs = RunService(splits, journal, engine, config.limits, config.clocks, accounts, quotas, closing)
    key = SigningKey(config.signing_key_path)
    KnownKeys(database).check(key.public)
    receipts = Receipts(database, splits, key, closing)
    notes = RunNotes(splits, journal, closing)
    stream_limits = StreamLimits(quotas, engine.worker)
    add_EvaluationServicer_to_server(
        EvaluationService(runs, notes, engine, receipts, config, threads, stream_limits), server
    )
    entries = Entries(database)
    local = config.is_for_own_machine
    limits = config.limits
    board = Board(
        entries, splits, steps_per_phase=limits.steps_per_phase, clocks=config.clocks, local=local, closing=closing
    )
    publisher = Publisher(journal, splits, entries, receipts, closing)
    epochs = EpochBoard(board, entries, EpochStore(database), journal, splits)
    add_LeaderboardServicer_to_server(LeaderboardService(board, publisher, epochs), server)
    health_servicer = health.HealthServicer()
    health_pb2_grpc.add_HealthServicer_to_server(health_servicer, server)
    reflection.enable_server_reflection(
        [*SERVICES, health_pb2.DESCRIPTOR.services_by_name["Health"].full_name, reflection.SERVICE_NAME], server
    )

    async def report(ready: bool) -> None:
        metrics.note_ready(ready)
        status = health_pb2.HealthCheckResponse
        for name in ("", *SERVICES):
            await health_servicer.set(name, status.SERVING if ready else status.NOT_SERVING)

    readiness = Readiness(lambda: journal.addresses(0.0), lambda: engine.last_round_at, report)

    def open_site() -> AbstractAsyncContextManager[dict[str, str]]:
        if not config.http:
            return nullcontext({})
        # Imported only here, as loading takes half a second, which an embedded server without pages should not spend.
        from arramon_server.process.browser_admission import browser_access
        from arramon_server.process.http_server import HttpServer
        from arramon_server.web.host import Host
        from arramon_server.web.pages import Pages
        from arramon_server.web.play.play_page import PlayPage
        from arramon_server.web.rendering import Renderer
        from arramon_server.web.server_options import ServerOptions
        from arramon_server.web.watch.sign_in import SignIn
        from arramon_server.web.watch.viewers import Viewers
        from arramon_server.web.web_parts import WebContext, WebPart, open_parts

        access, host = browser_access(authentication, stream_limits, config), Host.of(config)

        def web_parts(renderer: Renderer) -> list[WebPart]:
            services = (config, database, played_splits, journal, runs, engine, threads, renderer, access, host)
            return open_parts(WebContext(*services)) if config.web else []

        def play_page(renderer: Renderer) -> PlayPage:
            return PlayPage(config, access, runs, journal, publisher, engine, threads, renderer)

        play = play_page if config.play_page else None
        viewers, camera = Viewers.of(config, SignIn(access.authenticate, WatchPasses(database))), config.camera
        pages = Pages(
            board,
            journal,
            receipts,
            splits,
            epochs,
            host,
            play=play,
            parts=web_parts,
            viewers=viewers,
            camera=camera,
            server=ServerOptions.of(config, address, viewers),
        )
        return HttpServer(config, lambda: readiness.problem, metrics.text, pages).open()

    return ServerParts(server, address, engine, readiness, open_site())


def _server(config: Config, authentication: Authentication, metrics: PrometheusMetrics) -> grpc.aio.Server:
    return grpc.aio.server(
        interceptors=[
            ResponseWriter(),
            AccessLog(metrics.count_call),
            ErrorGuard(),
            VersionCheck(),
            authentication,
            CallLimits(config.max_calls),
        ],
        maximum_concurrent_rpcs=config.max_calls,
        options=[
            ("grpc.max_receive_message_length", config.max_message_bytes),
            ("grpc.server_handshake_timeout_ms", 20_000),  # for silent connections; gRPC's default is 120 s
            ("grpc.max_concurrent_streams", CALLS_PER_CONNECTION),
            # gRPC cancels waiting calls at random from 1,000 on; `max_calls` refuses them by a status of its own.
            ("grpc.server.max_pending_requests", 2 * config.max_calls),
            ("grpc.server.max_pending_requests_hard_limit", 4 * config.max_calls),
            ("grpc.so_reuseport", int(config.shared_port)),
            ("grpc.keepalive_time_ms", int(1000 * config.keepalive_seconds)),
            ("grpc.keepalive_timeout_ms", int(500 * config.keepalive_seconds)),
            ("grpc.http2.ping_timeout_ms", int(500 * config.keepalive_seconds)),  # default 60 s; the longer one counts
            ("grpc.keepalive_permit_without_calls", 1),
            ("grpc.http2.min_recv_ping_interval_without_data_ms", 5_000),
        ],
    )


def _bind(server: grpc.aio.Server, listen: str, credentials: grpc.ServerCredentials | None) -> str:
    """Add an address to the server; return it with its actual port. A Unix socket is local, and never encrypted."""
    try:
        if credentials is None or listen.startswith("unix:"):
            port = server.add_insecure_port(listen)
        else:
            port = server.add_secure_port(listen, credentials)
    except RuntimeError as error:
        raise BadInput(f"cannot listen on {listen!r}: it is in use, or not an address of this machine") from error
    if listen.startswith("unix:"):
        return listen
    return f"{listen.rpartition(':')[0]}:{port}"
