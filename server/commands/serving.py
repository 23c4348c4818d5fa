"""`serve` and `health`."""

import argparse

from server.commands import Commands
from server.commands.describing import describe
from server.config import LISTEN, MAX_WORKERS, Config
from server.episodes.splits import read_splits
from server.errors import BadInput
from server.health import check
from server.runs.database import Database
from server.serving import compile_camera, serve
from server.sim.cameras import CAMERAS
from server.sim.rules import STEPS_PER_PHASE, Limits
from server.workers import serve_with_workers


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds both."""
    serve_ = commands.add_parser("serve", parents=[common], help="serve the episodes of the data folder")
    serve_.add_argument("--listen", default=LISTEN, help="host:port or unix:/path (default: %(default)s)")
    serve_.add_argument("--journal", default="", help="database URL (default: SQLite in the data folder)")
    serve_.add_argument(
        "--steps", type=int, default=STEPS_PER_PHASE, help="step limit of a phase (default: %(default)s)"
    )
    serve_.add_argument(
        "--fsync",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="wait for the disk with every step, so that it outlives a loss of power, not only the end of a process",
    )
    serve_.add_argument(
        "--camera",
        default=CAMERAS[0],
        choices=CAMERAS,
        help="what draws: the fast one, or pybullet's (default: %(default)s)",
    )
    serve_.add_argument("--workers", type=int, default=1, help="processes that serve (default: %(default)s)")
    # How `workers` starts each of them.
    serve_.add_argument("--shared-port", action="store_true", help=argparse.SUPPRESS)
    serve_.add_argument("--own-address", default="", help=argparse.SUPPRESS)
    serve_.set_defaults(command=_serve)

    health = commands.add_parser("health", parents=[common], help="ask a server whether it serves; status 1 if not")
    health.add_argument("--address", default=LISTEN, help="host:port or unix:/path (default: %(default)s)")
    health.set_defaults(command=_health)


def _serve(arguments: argparse.Namespace) -> None:
    config = Config(
        data=arguments.data,
        listen=arguments.listen,
        shared_port=arguments.shared_port,
        own_address=arguments.own_address,
        journal=arguments.journal,
        camera=arguments.camera,
        fsync=arguments.fsync,
        limits=Limits(arguments.steps),
    )
    if not 1 <= arguments.workers <= MAX_WORKERS:
        raise BadInput(f"{arguments.workers} workers were asked for, expected 1 to {MAX_WORKERS}")
    splits = read_splits(config.data)
    for split in splits.values():
        print(describe(split), flush=True)

    def say(line: str) -> None:
        print(line, flush=True)

    if arguments.workers == 1:
        serve(config, splits, say)
        return
    compile_camera(config, say)  # once, as is the journal made or migrated, before all workers come to it
    Database(config.journal_url).close()
    own = [
        "--data",
        str(config.data),
        "--camera",
        config.camera,
        "--journal",
        config.journal,
        "--steps",
        str(config.limits.steps_per_phase),
    ]
    own += [] if config.fsync else ["--no-fsync"]
    serve_with_workers(arguments.workers, config.listen, [*own, "--log", arguments.log], say)


def _health(arguments: argparse.Namespace) -> None:
    check(arguments.address)
    print(f"{arguments.address} serves")
