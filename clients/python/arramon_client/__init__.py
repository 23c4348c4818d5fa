"""ArraMon client: connect an agent to an evaluation server, local or remote.

Authors of agents need `arramon_client.agent` and the command `arramon-client`. Programs that bring their own loop play
runs step by step with `Run` or `AsyncRun`. The other public names let programs use the functions of the command.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from arramon_client.agent import Action, Agent, Answer, AsyncAgent, Episode, Observation
    from arramon_client.errors import (
        AgentError,
        AgentLoadError,
        AgentStoppedError,
        ArramonClientError,
        EmbeddedServerError,
        EncryptionError,
        EpisodeLostError,
        MessageTooLargeError,
        NotArramonError,
        OutputError,
        ProtocolError,
        RefusedError,
        RunClosedError,
        ServerUnreachableError,
        StepAheadError,
        StepSpentError,
        StopRun,
        UsageError,
        VersionMismatchError,
    )
    from arramon_client.local.embedded import EmbeddedServer, embedded_server
    from arramon_client.multi_stream import play_async
    from arramon_client.play import Outcome, Progress, Settings, play
    from arramon_client.plugin.loader import load_agent
    from arramon_client.runs.async_run import AsyncRun, AsyncRunEpisode
    from arramon_client.runs.info import RunInfo
    from arramon_client.runs.run import Run, RunEpisode
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
    "Answer",
    "ArramonClientError",
    "AsyncAgent",
    "AsyncRun",
    "AsyncRunEpisode",
    "EmbeddedServer",
    "EmbeddedServerError",
    "EncryptionError",
    "Episode",
    "EpisodeLostError",
    "MessageTooLargeError",
    "NotArramonError",
    "Observation",
    "Outcome",
    "OutputError",
    "Progress",
    "ProtocolError",
    "RefusedError",
    "Run",
    "RunClosedError",
    "RunEpisode",
    "RunInfo",
    "Server",
    "ServerUnreachableError",
    "Settings",
    "StepAheadError",
    "StepSpentError",
    "StopRun",
    "UsageError",
    "VersionMismatchError",
    "connect",
    "embedded_server",
    "load_agent",
    "play",
    "play_async",
]

_HOMES = {
    **dict.fromkeys(("Action", "Agent", "Answer", "AsyncAgent", "Episode", "Observation"), "agent"),
    **dict.fromkeys(("EmbeddedServer", "embedded_server"), "local.embedded"),
    **dict.fromkeys(("Outcome", "Progress", "Settings", "play"), "play"),
    "play_async": "multi_stream",
    "load_agent": "plugin.loader",
    **dict.fromkeys(("AsyncRun", "AsyncRunEpisode"), "runs.async_run"),
    "RunInfo": "runs.info",
    **dict.fromkeys(("Run", "RunEpisode"), "runs.run"),
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
