"""A port that is held: servers may listen on it, one after the other; nobody else is given it."""

import socket
import sys

import pytest

from tests.ports import free_port

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="ports can be held on Linux only")


def test_servers_listen_on_a_held_port_one_after_the_other() -> None:
    port = free_port()
    for _ in range(2):
        with socket.create_server(("127.0.0.1", port)):
            socket.create_connection(("127.0.0.1", port), 60).close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port), 60)


def test_a_held_port_is_given_to_nobody_else() -> None:
    port = free_port()
    with socket.socket() as other, pytest.raises(OSError, match="in use"):
        other.bind(("127.0.0.1", port))
