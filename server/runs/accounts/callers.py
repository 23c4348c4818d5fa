"""The authenticated caller of a request, its role, and the runs that it may see."""

from dataclasses import dataclass
from enum import Enum

from arramon_server.runs.storage.records import Run


class Role(Enum):
    """Role of a caller."""

    ANONYMOUS = "anonymous"
    PARTICIPANT = "participant"
    HOST = "host"


@dataclass(frozen=True, slots=True)
class Caller:
    """The authenticated caller.

    Attributes:
        role: role of the caller.
        account: participant to whom the token belongs; None for an anonymous caller.
        may_list: whether the caller may list runs. The server cannot tell anonymous callers apart, so on a public
            server none of them may: only those who know the id of an anonymous run can access it.
        may_play: whether the caller may have runs; if not, it reads only what is published.
    """

    role: Role
    account: str | None = None
    may_list: bool = True
    may_play: bool = True

    def may_see(self, run: Run) -> bool:
        """Return whether the caller may see a run: hosts see all, participants their own, others the anonymous ones."""
        return self.role is Role.HOST or self.owns(run)

    def may_see_withheld(self, run: Run, *, published: bool) -> bool:
        """Return whether the caller sees all data of a run, also what frozen and hidden splits withhold from others.

        The leaderboard shows the id of a published run to everybody: on a public server, knowing the id then no longer
        identifies the owner of an anonymous run.

        Args:
            run: the run.
            published: whether it is on the leaderboard.
        """
        return self.may_see(run) and (self.role is not Role.ANONYMOUS or self.may_list or not published)

    def owns(self, run: Run) -> bool:
        """Return whether the caller owns a run and may play it: anonymous runs belong to all anonymous callers."""
        return self.may_play and run.account == self.account


ANONYMOUS = Caller(Role.ANONYMOUS)
"""Anonymous caller on a private server, who may list runs."""

UNAUTHENTICATED = Caller(Role.ANONYMOUS, may_list=False)
"""Anonymous caller on a public server, who may not list runs, publish or withdraw."""

READER = Caller(Role.ANONYMOUS, may_list=False, may_play=False)
"""Anonymous caller on a server where playing needs a token."""

HOST = Caller(Role.HOST, may_play=False)
"""The host at its own command line."""
