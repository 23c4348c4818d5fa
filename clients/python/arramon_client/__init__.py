"""ArraMon client: connect an agent to an evaluation server, local or remote.

An agent's author needs `arramon_client.agent` and the command `arramon-client`. The other public names let a program do
what the command does.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from arramon_client.agent import Action, Agent, Episode, Observation
    from arramon_client.errors import (
        AgentError,
        AgentLoadError,
        AgentStoppedError,
        ArramonClientError,
        EmbeddedServerError,
        EncryptionError,
        MessageTooLargeError,
        NotArramonError,
        OutputError,
        ProtocolError,
        RefusedError,
        ServerUnreachableError,
        UsageError,
        VersionMismatchError,
    )
    from arramon_client.local.embedded import EmbeddedServer, embedded_server
    from arramon_client.play import Outcome, Progress, Settings, play
    from arramon_client.plugin.loader import load_agent
    from arramon_client.session import AgentFailure
    from arramon_client.transport.access import Access
    from arramon_client.transport.connection import Server, connect

__all__ = [
    "Access",
    "Action",
    "Agent",
    "AgentError",
    "AgentFailure",
    "AgentLoadError",
    "AgentStoppedError",
    "ArramonClientError",
    "EmbeddedServer",
    "EmbeddedServerError",
    "EncryptionError",
    "Episode",
    "MessageTooLargeError",
    "NotArramonError",
    "Observation",
    "Outcome",
    "OutputError",
    "Progress",
    "ProtocolError",
    "RefusedError",
    "Server",
    "ServerUnreachableError",
    "Settings",
    "UsageError",
    "VersionMismatchError",
    "connect",
    "embedded_server",
    "load_agent",
    "play",
]

_HOMES = {
    **dict.fromkeys(("Action", "Agent", "Episode", "Observation"), "agent"),
    **dict.fromkeys(("EmbeddedServer", "embedded_server"), "local.embedded"),
    **dict.fromkeys(("Outcome", "Progress", "Settings", "play"), "play"),
    "load_agent": "plugin.loader",
    "AgentFailure": "session",
    "Access": "transport.access",
    **dict.fromkeys(("Server", "connect"), "transport.connection"),
}
"""Modules of this package that define the public names; the errors are in `errors`."""


class _Package(ModuleType):
    """This package, whose public names are imported when they are first used: environments in process need no gRPC."""

    @property
    def play(self) -> Any:
        """The function; the module of that name is `arramon_client.play` to the import system alone."""
        return import_module(f"{__name__}.play").play

    @play.setter
    def play(self, module: ModuleType) -> None:
        """Ignore the module, which the import system puts here."""


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_HOMES.get(name, 'errors')}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
