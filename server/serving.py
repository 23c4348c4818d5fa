"""Starts the server, and stops it: what `arramon-server serve` does."""

import asyncio
import logging
import signal
from collections.abc import Callable, Mapping
from contextlib import closing, suppress

import grpc
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_health.v1.health import aio as health
from grpc_reflection.v1alpha import reflection

from arramon.v1 import evaluation_pb2, leaderboard_pb2
from arramon.v1.evaluation_pb2_grpc import add_EvaluationServicer_to_server
from arramon.v1.leaderboard_pb2_grpc import add_LeaderboardServicer_to_server
from server.api.authentication import Authentication
from server.api.board import BoardServicer
from server.api.guard import Guard
from server.api.servicer import Servicer
from server.api.versions import VersionCheck
from server.board.board import Board
from server.board.entries import Entries
from server.board.publishing import Publishing
from server.config import Config
from server.episodes.splits import Split
from server.errors import BadInput
from server.runs.accounts import Accounts
from server.runs.database import Database
from server.runs.engine import Engine
from server.runs.journal import Journal
from server.runs.ledger import Ledger
from server.runs.quotas import Quota, Quotas
from server.runs.receipts import Receipts
from server.runs.service import Runs
from server.runs.signing import KnownKeys, SigningKey
from server.sim.raster import compile_kernels, is_compiled
from server.tls import credentials_of

SERVICES = (
    evaluation_pb2.DESCRIPTOR.services_by_name["Evaluation"].full_name,
    leaderboard_pb2.DESCRIPTOR.services_by_name["Leaderboard"].full_name,
)
"""This project's own."""

DRAIN_SECONDS = 5.0
"""How long calls may take to end when the server stops."""

COMPILING = "compiling the camera; this is done once and takes about half a minute"
"""Announced where the fast camera has never been compiled on this machine."""

_log = logging.getLogger(__name__)


def serve(config: Config, splits: Mapping[str, Split], announce: Callable[[str], None]) -> None:
    """Serves until SIGTERM or SIGINT.

    Args:
        config: the host's settings.
        splits: what is served, by name.
        announce: told where the server listens and what it serves, once it does.

    Raises:
        ArraMonError: if the journal or the address is not right.
    """
    compile_camera(config, announce)
    with closing(Database(config.journal_url, fsync=config.fsync)) as database:
        asyncio.run(_serve(config, splits, database, announce))


def compile_camera(config: Config, announce: Callable[[str], None]) -> None:
    """Makes sure that what draws is compiled, and announces it where that takes long."""
    if config.camera != "raster":
        return
    if not is_compiled():
        announce(COMPILING)
    compile_kernels()


async def _serve(
    config: Config, splits: Mapping[str, Split], database: Database, announce: Callable[[str], None]
) -> None:
    journal, accounts = Journal(database), Accounts(database)
    quotas = Quotas(database, Quota.of_settings(config))
    server = grpc.aio.server(
        interceptors=[Guard(), VersionCheck(), Authentication(accounts, config)],
        options=[
            ("grpc.max_receive_message_length", config.max_message_bytes),
            ("grpc.so_reuseport", int(config.shared_port)),
            ("grpc.keepalive_time_ms", 20_000),
            ("grpc.keepalive_timeout_ms", 10_000),
            ("grpc.keepalive_permit_without_calls", 1),
            ("grpc.http2.min_recv_ping_interval_without_data_ms", 5_000),
        ],
    )
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
    )
    runs = Runs(splits, journal, engine, config.limits, config.clocks, accounts, quotas)
    key = SigningKey(config.signing_key_path)
    KnownKeys(database).check(key.public)
    receipts = Receipts(database, splits, key)
    add_EvaluationServicer_to_server(Servicer(runs, engine, receipts, config), server)
    entries = Entries(database)
    board = Board(entries, splits, steps_per_phase=config.limits.steps_per_phase)
    publishing = Publishing(journal, splits, entries, receipts)
    add_LeaderboardServicer_to_server(BoardServicer(board, publishing), server)
    health_servicer = health.HealthServicer()
    health_pb2_grpc.add_HealthServicer_to_server(health_servicer, server)
    reflection.enable_server_reflection(
        [*SERVICES, health_pb2.DESCRIPTOR.services_by_name["Health"].full_name, reflection.SERVICE_NAME], server
    )
    await server.start()
    stopping = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, stopping.set)
    engine.start()
    playing = asyncio.create_task(engine.run())
    for name in ("", *SERVICES):
        await health_servicer.set(name, health_pb2.HealthCheckResponse.SERVING)
    announce(f"listening on {address}")
    stopped = asyncio.create_task(stopping.wait())
    # An engine that breaks down ends the process, and with it what is only in memory.
    await asyncio.wait([playing, stopped], return_when=asyncio.FIRST_COMPLETED)
    _log.info("stopping")
    stopped.cancel()
    playing.cancel()
    await health_servicer.enter_graceful_shutdown()
    engine.stop()
    with suppress(TimeoutError):  # calls that do not end in time end with the process
        await asyncio.wait_for(server.stop(DRAIN_SECONDS), 2 * DRAIN_SECONDS)
    with suppress(asyncio.CancelledError):
        await playing


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
