"""The error tree: everything that can go wrong for a participant, in words that say what to do about it.

ArramonClientError
├── UsageError            an argument names what does not exist, or contradicts another
├── OutputError           the results cannot be written
├── ReceiptError          a receipt was altered, is signed with another key, or is not about what was played
├── ServerUnreachableError    no server answers there, or it was lost for too long
│   ├── EncryptionError       what answers there does not encrypt as was expected
│   └── EmbeddedServerError   the server that this client started itself
├── NotArramonError       something answers there, but it is not an ArraMon server
├── VersionMismatchError  client and server speak different protocols
├── RefusedError          the server said no; carries its status code
│   └── MessageTooLargeError
├── ProtocolError         the server reported a fault of this client's own, or said what this client cannot understand
└── AgentError            the agent's code failed; carries the tail of its own traceback
    └── AgentLoadError    it cannot be imported or made
"""

import grpc


class ArramonClientError(Exception):
    """Base of all errors whose message may be shown to a user as it is."""


class UsageError(ArramonClientError):
    """An argument names something that does not exist, or contradicts another; the message names what does exist."""


class OutputError(ArramonClientError):
    """The results cannot be written where they should go."""


class ReceiptError(ArramonClientError):
    """A receipt cannot be read, was altered, is signed with another key, or is not about what this client played."""


class ServerUnreachableError(ArramonClientError):
    """No server answers at the address, or the connection was lost and did not come back in time."""


class EncryptionError(ServerUnreachableError):
    """What answers at the address does not encrypt, or not with a certificate to trust: waiting does not help."""


class EmbeddedServerError(ServerUnreachableError):
    """The server that this client started itself is not installed, did not start, or died."""


class NotArramonError(ArramonClientError):
    """Something answers at the address, but it does not know the ArraMon protocol."""


class VersionMismatchError(ArramonClientError):
    """Client and server speak different protocols; the message says which to upgrade."""


class RefusedError(ArramonClientError):
    """The server refused a request.

    Attributes:
        code: the gRPC status.
    """

    def __init__(self, message: str, code: grpc.StatusCode) -> None:
        super().__init__(message)
        self.code = code


class MessageTooLargeError(RefusedError):
    """A message is larger than one of the two sides accepts."""


class ProtocolError(ArramonClientError):
    """Server and client misunderstand each other: a defect of one of the two, to be reported to its authors."""


class AgentError(ArramonClientError):
    """The agent's code failed.

    Attributes:
        details: the tail of the agent's own traceback, without the frames of this client; empty where there is none.
    """

    def __init__(self, message: str, details: str = "") -> None:
        super().__init__(message)
        self.details = details


class AgentLoadError(AgentError):
    """The agent cannot be imported or made."""
