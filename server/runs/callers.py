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
        lists: whether their runs can be listed. The anonymous are all one to the server, so where they are strangers
            to each other none of them may: a run is then theirs who know its id.
    """

    role: Role
    account: str | None = None
    lists: bool = True

    def may_see(self, run: Run) -> bool:
        """Whether a run is this caller's: hosts see all, participants their own, the anonymous what has no owner."""
        return self.role is Role.HOST or run.account == self.account


ANONYMOUS = Caller(Role.ANONYMOUS)
"""Somebody on a server of their own."""

STRANGER = Caller(Role.ANONYMOUS, lists=False)
"""Somebody anonymous on a server that is open to everyone."""

HOST = Caller(Role.HOST)
"""The host itself, at its own command line."""
