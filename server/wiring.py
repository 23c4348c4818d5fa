"""Puts the parts of a server process together; `serving` starts and stops them."""

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
from server.api.access import Access
from server.api.authentication import Authentication
from server.api.board import BoardServicer
from server.api.crowding import Crowding
from server.api.guard import Guard
from server.api.servicer import Servicer
from server.api.versions import VersionCheck
from server.board.board import Board
from server.board.entries import Entries
from server.board.publishing import Publishing
from server.config import Config
from server.episodes.splits import Split
from server.errors import BadInput
from server.metrics import Metrics
from server.readiness import Readiness
from server.runs.accounts import Accounts
from server.runs.census import runs_by_state
from server.runs.counted import CountedJournal
from server.runs.database import Database
from server.runs.engine import Engine
from server.runs.ledger import Ledger
from server.runs.quotas import Quota, Quotas
from server.runs.receipts import Receipts
from server.runs.service import Runs
from server.runs.signing import KnownKeys, SigningKey
from server.tls import credentials_of

SERVICES = (
    evaluation_pb2.DESCRIPTOR.services_by_name["Evaluation"].full_name,
    leaderboard_pb2.DESCRIPTOR.services_by_name["Leaderboard"].full_name,
)
"""This project's own."""


@dataclass(frozen=True)
class Parts:
    """What runs in a server process.

    Attributes:
        server: takes the calls.
        address: where it listens.
        engine: plays.
        readiness: tells the health service, and the metrics.
        web: serves probes, metrics and pages while it is entered, and gives what is served where.
    """

    server: grpc.aio.Server
    address: str
    engine: Engine
    readiness: Readiness
    web: AbstractAsyncContextManager[dict[str, str]]


def wire(config: Config, splits: Mapping[str, Split], database: Database) -> Parts:
    """All parts of a process, none of them started.

    Raises:
        ArraMonError: if a file, the journal or the address is not right.
    """
    metrics = Metrics(config.camera, lambda: runs_by_state(database))
    journal, accounts = CountedJournal(database, metrics), Accounts(database)
    server = _server(config, accounts, metrics)
    credentials = credentials_of(config)
    address = _bind(server, config.listen, credentials)
    own_address = _bind(server, config.own_address, credentials) if config.own_address else address
    engine = Engine(
        splits,
        journal,
        Ledger(database),
        camera=config.camera,
        address=own_address if config.shared_port else "",
        idle_seconds=config.idle_seconds,
        meter=metrics,
    )
    runs = Runs(
        splits, journal, engine, config.limits, config.clocks, accounts, Quotas(database, Quota.of_settings(config))
    )
    key = SigningKey(config.signing_key_path)
    KnownKeys(database).check(key.public)
    receipts = Receipts(database, splits, key)
    add_EvaluationServicer_to_server(Servicer(runs, engine, receipts, config), server)
    entries = Entries(database)
    board = Board(entries, splits, steps_per_phase=config.limits.steps_per_phase, clocks=config.clocks)
    publishing = Publishing(journal, splits, entries, receipts)
    add_LeaderboardServicer_to_server(BoardServicer(board, publishing), server)
    health_servicer = health.HealthServicer()
    health_pb2_grpc.add_HealthServicer_to_server(health_servicer, server)
    reflection.enable_server_reflection(
        [*SERVICES, health_pb2.DESCRIPTOR.services_by_name["Health"].full_name, reflection.SERVICE_NAME], server
    )

    async def tell(ready: bool) -> None:
        metrics.ready(ready)
        status = health_pb2.HealthCheckResponse
        for name in ("", *SERVICES):
            await health_servicer.set(name, status.SERVING if ready else status.NOT_SERVING)

    readiness = Readiness(lambda: journal.addresses(0.0), lambda: engine.turned_at, tell)

    def over_http() -> AbstractAsyncContextManager[dict[str, str]]:
        if not config.http:
            return nullcontext({})
        # Only here, as they take half a second to load, for which whoever plays with an embedded server would wait.
        from server.web.pages import Pages
        from server.web.site import Site

        pages = Pages(board, journal, receipts, splits)
        return Site(config, lambda: readiness.problem, metrics.text, pages).open()

    return Parts(server, address, engine, readiness, over_http())


def _server(config: Config, accounts: Accounts, metrics: Metrics) -> grpc.aio.Server:
    return grpc.aio.server(
        interceptors=[
            Access(metrics.called),
            Guard(),
            VersionCheck(),
            Authentication(accounts, config),
            Crowding(config.max_calls),
        ],
        maximum_concurrent_rpcs=config.max_calls,
        options=[
            ("grpc.max_receive_message_length", config.max_message_bytes),
            ("grpc.server_handshake_timeout_ms", 20_000),  # for connections that say nothing: gRPC gives them 120
            ("grpc.so_reuseport", int(config.shared_port)),
            ("grpc.keepalive_time_ms", int(1000 * config.keepalive_seconds)),
            ("grpc.keepalive_timeout_ms", int(500 * config.keepalive_seconds)),
            ("grpc.http2.ping_timeout_ms", int(500 * config.keepalive_seconds)),  # or a minute: the longer one counts
            ("grpc.keepalive_permit_without_calls", 1),
            ("grpc.http2.min_recv_ping_interval_without_data_ms", 5_000),
        ],
    )


def _bind(server: grpc.aio.Server, listen: str, credentials: grpc.ServerCredentials | None) -> str:
    """Nobody reads along on a Unix socket: it is never encrypted."""
    try:
        if credentials is None or listen.startswith("unix:"):
            port = server.add_insecure_port(listen)
        else:
            port = server.add_secure_port(listen, credentials)
    except RuntimeError as error:
        raise BadInput(f"cannot listen on {listen!r}: it is in use, or not of this machine") from error
    if listen.startswith("unix:"):
        return listen
    return f"{listen.rpartition(':')[0]}:{port}"
