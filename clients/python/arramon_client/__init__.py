"""ArraMon client: connect an agent to an evaluation server, local or remote.

An agent's author needs `arramon_client.agent` and the command `arramon-client`. The other public names let a program do
what the command does.
"""

from arramon_client import requirements  # noqa: F401 - before all that needs them

# isort: split
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
