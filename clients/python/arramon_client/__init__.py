"""ArraMon client: connect an agent to an evaluation server, local or remote.

Authors of agents need `arramon_client.agent` and the command `arramon-client`. The other public names let programs use
the functions of the command.
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
"""Module that defines each public name; names that are not listed are in `errors`."""


class _Package(ModuleType):
    """This package, which imports public names on first use, so that environments in this process need no gRPC."""

    @property
    def play(self) -> Any:
        """The function `play`; only the import system uses this name for the module `arramon_client.play`."""
        return import_module(f"{__name__}.play").play

    @play.setter
    def play(self, module: ModuleType) -> None:
        """Ignore the module that the import system assigns to this attribute."""


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_HOMES.get(name, 'errors')}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
