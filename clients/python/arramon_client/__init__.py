"""Play ArraMon: connect an agent to an evaluation server, local or remote.

An agent's author needs `arramon_client.agent` and the command `arramon-client`; what else is public here lets a program
do what the command does.
"""

from arramon_client.access import Access
from arramon_client.agent import Action, Agent, Episode, Observation
from arramon_client.connection import Server, connect
from arramon_client.embedded import EmbeddedServer, embedded_server
from arramon_client.errors import (
    AgentError,
    AgentLoadError,
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
from arramon_client.loading import load_agent
from arramon_client.play import Outcome, Progress, Settings, play
from arramon_client.session import AgentFailure

__all__ = [
    "Access",
    "Action",
    "Agent",
    "AgentError",
    "AgentFailure",
    "AgentLoadError",
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
