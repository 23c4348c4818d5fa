"""A server on tiny splits that requires a token, behind a forwarder; no check is skipped on it."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_client.transport.access import Access
from tests import tiny
from tests.api.people import token_of
from tests.conformance.forwarder import Forwarder, forwarding
from tests.serving import Server


@pytest.fixture(scope="package")
def folder() -> Iterator[Path]:
    """A folder whose path is short enough for a socket's."""
    with tempfile.TemporaryDirectory(prefix="arramon-") as folder:
        yield Path(folder)


@pytest.fixture(scope="package")
def server(folder: Path) -> Iterator[Server]:
    tiny.write(folder)
    tiny.write(folder, "secret", 3, hidden=True)
    limits = ("--runs-per-day", "0", "--runs-at-once", "0")  # the checks of all tests are played on it
    server = Server(folder, f"unix:{folder}/server", "--steps", "8", "--no-anonymous", "--no-fsync", *limits)
    yield server
    server.stop()


@pytest.fixture(scope="package")
def token(server: Server) -> str:
    return token_of(server.data, "ann")


@pytest.fixture(scope="package")
def access(token: str) -> Access:
    return Access(token=token)


@pytest.fixture(scope="package")
def forwarder(server: Server, folder: Path) -> Iterator[Forwarder]:
    with forwarding(server.address, f"unix:{folder}/forwarder") as forwarder:
        yield forwarder
