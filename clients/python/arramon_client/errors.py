"""Exceptions of the client; every message can be shown to a participant as it is.

ArramonClientError
├── UsageError            an argument names something that does not exist, or contradicts another argument
├── OutputError           the results cannot be written
├── ReceiptError          a receipt was altered, is signed with another key, or does not match the run that was played
├── ServerUnreachableError    no server answers, or the connection was lost for too long
│   ├── EncryptionError       encryption failed, or the server's certificate is not trusted
│   └── EmbeddedServerError   the embedded server is not installed, did not start, or died
├── NotArramonError       the program that answers is not an ArraMon server
├── VersionMismatchError  client and server speak different protocols
├── RefusedError          the server refused a request; carries its status code
│   └── MessageTooLargeError
├── ProtocolError         client and server violate the protocol: a defect of one of them
├── StepSpentError        an act for a step that was answered before with another action
├── StepAheadError        an act for a step whose observation has not been sent yet
├── EpisodeLostError      another client has taken over the episode
├── RunClosedError        the run was closed in this program; it can be resumed
├── StopRun               raised by an agent to stop its run in order; the run can be resumed
└── AgentError            the agent's code failed; carries the tail of its own traceback
    ├── AgentLoadError    the agent cannot be imported or constructed
    └── AgentStoppedError the agent failed early or often, and its run was stopped; the run can be resumed
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import grpc


class ArramonClientError(Exception):
    """Base class of all errors; the message can be shown to a user as it is."""


class UsageError(ArramonClientError):
    """An argument names something that does not exist, or contradicts another; the message lists the alternatives."""


class OutputError(ArramonClientError):
    """The results cannot be written to the output folder."""


class ReceiptError(ArramonClientError):
    """A receipt cannot be read, was altered, is signed with another key, or does not match what this client played."""


class ServerUnreachableError(ArramonClientError):
    """No server answers at the address, or a lost connection could not be restored in time."""


class EncryptionError(ServerUnreachableError):
    """The server does not use TLS, or its certificate is not trusted; a retry does not help."""


class EmbeddedServerError(ServerUnreachableError):
    """The embedded server is not installed, did not start, or died."""


class NotArramonError(ArramonClientError):
    """The program that answers at the address does not implement the ArraMon protocol."""


class VersionMismatchError(ArramonClientError):
    """Client and server speak different protocols; the message says which one to upgrade."""


class RefusedError(ArramonClientError):
    """The server refused a request.

    Attributes:
        code: the gRPC status.
    """

    def __init__(self, message: str, code: "grpc.StatusCode") -> None:
        super().__init__(message)
        self.code = code


class MessageTooLargeError(RefusedError):
    """A message is larger than the client or the server accepts."""


class ProtocolError(ArramonClientError):
    """Client and server violate the protocol: a defect of one of them, to be reported to its authors."""


class StepSpentError(ArramonClientError):
    """An act names a step that was answered before with another action, which remains recorded.

    Attributes:
        episode_id: the episode.
        step: the step that the act names.
        present: the step that awaits an action; None if the episode has ended.
        recorded: the action recorded at `step`, 0 to 3; None if this client does not know it.
    """

    def __init__(self, episode_id: str, step: int, present: int | None, recorded: int | None) -> None:
        self.episode_id, self.step, self.present, self.recorded = episode_id, step, present, recorded
        was = "was answered before" if recorded is None else f"was answered with {recorded}"
        now = "the episode has ended" if present is None else f"the present step is {present}"
        super().__init__(f"step {step} of episode {episode_id} {was}, which remains recorded; {now}")


class StepAheadError(ArramonClientError):
    """An act names a step that is ahead of the present one, whose observation has not been sent yet.

    Attributes:
        episode_id: the episode.
        step: the step that the act names.
        present: the step that awaits an action.
    """

    def __init__(self, episode_id: str, step: int, present: int) -> None:
        self.episode_id, self.step, self.present = episode_id, step, present
        super().__init__(f"step {step} of episode {episode_id} is ahead of the present step, {present}")


class EpisodeLostError(ArramonClientError):
    """Another client, or another stream of this one, has taken over the episode."""


class RunClosedError(ArramonClientError):
    """The run was closed in this program while it was used; it can be resumed."""


class StopRun(ArramonClientError):
    """Raised by an agent's `act` to stop its run in order, for example because a limit of calls or cost is reached.

    Nothing is given up, and the run can be resumed.

    Attributes:
        limit: the agent's argument that holds the limit that was reached, such as "max_calls"; empty if none was.
    """

    def __init__(self, message: str = "", limit: str = "") -> None:
        super().__init__(message)
        self.limit = limit


class AgentError(ArramonClientError):
    """The agent's code failed; or its `act` raises this itself, to state a failure without a traceback.

    Attributes:
        details: the tail of the agent's traceback, without the frames of this client; empty if there is none.
    """

    def __init__(self, message: str, details: str = "") -> None:
        super().__init__(message)
        self.details = details


class AgentLoadError(AgentError):
    """The agent cannot be imported or constructed."""


class AgentStoppedError(AgentError):
    """The agent failed before its first valid action, or in several episodes in a row, and its run was stopped."""
