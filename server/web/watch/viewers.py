"""Callers of the watch pages: who has signed in, or those who may play without a token, as over gRPC, or everybody."""

from aiohttp import web

from arramon_server.configuration.config import Config
from arramon_server.runs.accounts.callers import ANONYMOUS, READER, UNAUTHENTICATED, Caller
from arramon_server.web.watch.sign_in import SignIn
from arramon_server.web.watch.viewer_addresses import is_local


class Viewers:
    """Derives the caller of a request for a page.

    Args:
        anonymous: the setting of that name: whether anyone may play without a token; None for this machine only.
        own_machine: whether only this machine can reach the server over gRPC.
        sign_in: finds who has signed in; None if nobody can.

    Attributes:
        sign_in: see the argument.
    """

    def __init__(
        self, anonymous: bool | None = False, *, own_machine: bool = False, sign_in: SignIn | None = None
    ) -> None:
        self._anonymous = anonymous
        self._own_machine = own_machine
        self.sign_in = sign_in

    @classmethod
    def of(cls, config: Config, sign_in: SignIn | None = None) -> "Viewers":
        """Return the viewers under a host's settings."""
        return cls(config.anonymous, own_machine=config.is_for_own_machine, sign_in=sign_in)

    def caller(self, request: web.BaseRequest) -> Caller:
        """Return the caller of a request. Call it in a thread.

        It is the participant or host who has signed in. Without sign-in it is as over gRPC without a token, or READER
        if such callers may not play.
        """
        signed_in = self.sign_in.caller(request) if self.sign_in is not None else None
        if signed_in is not None:
            return signed_in
        return self._without_token(request)

    def needs_token(self, request: web.BaseRequest) -> bool:
        """Return whether the caller of a request needs a token to play; a pass of who has signed in is none."""
        return not self._without_token(request).may_play

    @property
    def lists_on_own_machine(self) -> bool:
        """Whether callers on this machine see the runs without account."""
        return self._own_machine and self._anonymous is not False

    def _without_token(self, request: web.BaseRequest) -> Caller:
        if self.lists_on_own_machine and is_local(request):
            return ANONYMOUS
        return UNAUTHENTICATED if self._anonymous else READER


NOBODY = Viewers()
"""Viewers on a server where nobody plays without a token: they see what is published."""
