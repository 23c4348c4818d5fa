"""Who calls: a participant or host by token, or somebody anonymous, and what they may see."""

from dataclasses import dataclass
from enum import Enum

from server.runs.records import Run


class Role(Enum):
    """What a caller is to the server."""

    ANONYMOUS = "anonymous"
    PARTICIPANT = "participant"
    HOST = "host"


@dataclass(frozen=True, slots=True)
class Caller:
    """Whom the server takes a caller for.

    Attributes:
        account: the participant that the token belongs to; None for an anonymous caller.
    """

    role: Role
    account: str | None = None

    def may_see(self, run: Run) -> bool:
        """Whether a run is this caller's: hosts see all, participants their own, the anonymous what has no owner."""
        return self.role is Role.HOST or run.account == self.account


ANONYMOUS = Caller(Role.ANONYMOUS)
HOST = Caller(Role.HOST)
"""The host itself, at its own command line."""
