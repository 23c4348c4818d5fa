"""The commands `serve` and `health`: run a server, or check one."""

import argparse

from arramon_server.addresses import check_address_free
from arramon_server.commands import Commands
from arramon_server.commands.split_description import describe_split
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import add_serving_flags
from arramon_server.episodes.splits import read_splits
from arramon_server.process.health import check
from arramon_server.process.lifecycle import check_limited_splits, check_secrets, compile_camera, serve
from arramon_server.process.workers import serve_with_workers
from arramon_server.runs.storage.database import Database


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add both commands."""
    serve_ = commands.add_parser("serve", parents=[common], help="serve the episodes of the data folder")
    add_serving_flags(serve_)
    serve_.set_defaults(command=_serve)

    health = commands.add_parser(
        "health", parents=[common], help="check whether a server is ready for calls; exit status 1 if not"
    )
    health.add_argument("--address", help="address of the server, host:port or unix:/path (default: setting `listen`)")
    health.set_defaults(command=_health)


def _serve(arguments: argparse.Namespace) -> None:
    config: Config = arguments.settings
    if not config.shared_port:  # A shared port is in use: the parent process reserves it for its workers.
        check_address_free(config.listen)
    splits = read_splits(config.data)
    for split in splits.values():
        print(describe_split(split), flush=True)
    check_limited_splits(config, splits)
    check_secrets(config, splits)

    def announce(line: str) -> None:
        print(line, flush=True)

    if config.workers == 1:
        serve(config, splits, announce)
        return
    compile_camera(config, announce)  # Done once, like the journal's creation and migration, before the workers start.
    Database(config.journal_url).close()
    serve_with_workers(config, announce)


def _health(arguments: argparse.Namespace) -> None:
    address = arguments.address or arguments.settings.listen
    check(address, arguments.settings.tls_certificate)
    print(f"{address} serves")
