"""The connection of a run: to a remote server, or to an embedded one that it starts."""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from arramon_client.errors import UsageError
from arramon_client.local.embedded_play import embedded_for_play
from arramon_client.runs.options import ServerOptions
from arramon_client.transport.access import Access, make_access
from arramon_client.transport.connection import Server, connect, raise_unreachable
from arramon_client.transport.retry import PATIENCE, Retry

_log = logging.getLogger("arramon_client.runs")


class Connection:
    """A connected server, remote or embedded.

    Args:
        options: the server.
        needs_episodes: whether an embedded server without episodes must generate some.
        resumes: the run that is resumed, whose server may be restarting; empty for a new one.
        patience: seconds to wait for that server.

    Raises:
        ArramonClientError: if the server cannot be reached or started, or refuses.

    Attributes:
        server: the server.
        revive: restarts an embedded server that has died.
        notify: called with messages for the participant.
    """

    def __init__(
        self,
        options: ServerOptions,
        *,
        needs_episodes: bool = False,
        resumes: str = "",
        patience: float = PATIENCE,
    ) -> None:
        self.notify = options.get("notify") or _log.warning
        self.revive: Callable[[], None] = lambda: None
        self._stack = ExitStack()
        try:
            address, access, unreachable = options.get("server"), Access(), raise_unreachable
            data, tls_ca = options.get("data"), options.get("tls_ca")
            if address is None:
                embedded = self._stack.enter_context(
                    embedded_for_play(
                        None if data is None else Path(data), self.notify, needs_episodes=needs_episodes, quiet=True
                    )
                )
                address, self.revive = embedded.address, embedded.revive
            else:
                if data is not None:
                    raise UsageError("data applies to the embedded server, and cannot be used together with server")
                access = make_access(
                    options.get("token"), tls=options.get("tls"), tls_ca=None if tls_ca is None else Path(tls_ca)
                )
                if resumes:
                    unreachable = Retry(resumes, patience, self.notify).wait_for
            self.server: Server = self._stack.enter_context(connect(address, access, unreachable=unreachable))
        except BaseException:
            self._stack.close()
            raise

    def close(self) -> None:
        """Close the connection, and stop an embedded server; a second call does nothing."""
        self._stack.close()
