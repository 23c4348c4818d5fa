"""Free ports for servers of tests: they stay free until the server is started, and while it is restarted."""

import socket
import sys
import weakref

_HELD: list[socket.socket] = []


def free_port(host: str = "127.0.0.1", *, holder: object = None) -> int:
    """Return a port on which nobody listens, and which the system gives to nobody else.

    A socket stays bound to it without listening: until `holder` is collected, or until this process ends. Linux lets a
    server that sets SO_REUSEADDR, as all do, bind the port beside such a socket, and gives it to no connection and to
    nobody who asks for any port. Elsewhere the port is only free at the moment.
    """
    held = socket.socket()
    held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if sys.platform == "linux":
        held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)  # which a server with several processes sets
    held.bind((host, 0))
    port: int = held.getsockname()[1]
    if sys.platform != "linux":
        held.close()
    elif holder is None:
        _HELD.append(held)
    else:
        weakref.finalize(holder, held.close)
    return port
