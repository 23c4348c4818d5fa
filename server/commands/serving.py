"""`serve` and `health`."""

import argparse

from server.addresses import check_free
from server.commands import Commands
from server.commands.describing import describe
from server.config import Config
from server.configuring import add_serving_flags
from server.episodes.splits import read_splits
from server.health import check
from server.runs.database import Database
from server.serving import compile_camera, serve
from server.workers import serve_with_workers


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds both."""
    serve_ = commands.add_parser("serve", parents=[common], help="serve the episodes of the data folder")
    add_serving_flags(serve_)
    serve_.set_defaults(command=_serve)

    health = commands.add_parser("health", parents=[common], help="ask a server whether it serves; status 1 if not")
    health.add_argument("--address", help="host:port or unix:/path (default: the setting `listen`)")
    health.set_defaults(command=_health)


def _serve(arguments: argparse.Namespace) -> None:
    config: Config = arguments.settings
    if not config.shared_port:  # Nor is what the first of several processes holds for them all.
        check_free(config.listen)
    splits = read_splits(config.data)
    for split in splits.values():
        print(describe(split), flush=True)

    def say(line: str) -> None:
        print(line, flush=True)

    if config.workers == 1:
        serve(config, splits, say)
        return
    compile_camera(config, say)  # once, as is the journal made or migrated, before all workers come to it
    Database(config.journal_url).close()
    serve_with_workers(config, say)


def _health(arguments: argparse.Namespace) -> None:
    address = arguments.address or arguments.settings.listen
    check(address, arguments.settings.tls_certificate)
    print(f"{address} serves")
