"""Who is calling: from a call's metadata to a `Caller`. Stands before every method, so that none can forget to ask."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import aclosing
from contextvars import ContextVar
from hashlib import sha256
from typing import Any

import grpc

from server.addresses import is_loopback
from server.api.wrapping import Context, Continuation, Handler, Work, wrapped
from server.config import Config
from server.errors import Forbidden, StorageError, Unauthenticated
from server.runs.accounts import Accounts
from server.runs.callers import ANONYMOUS, STRANGER, Caller

OPEN = frozenset({
    "/arramon.v1.Evaluation/GetServerInfo",
    "/arramon.v1.Leaderboard/List",
    "/arramon.v1.Leaderboard/GetEntry",
    "/arramon.v1.Leaderboard/Export",
})  # fmt: skip
"""Methods for everyone, also where nobody plays without a token. Their callers may be anonymous."""

KNOWN_SECONDS, KNOWN_TOKENS = 2.0, 10_000
"""How long a token is not looked up again, and how many are remembered: a revoked one is refused after that long. Open
streams are asked again as often, with what they are told."""

_caller: ContextVar[Caller] = ContextVar("caller")


def caller_of(context: Context) -> Caller:  # noqa: ARG001 - that of the call in whose context this runs
    """Whom a call comes from.

    Raises:
        LookupError: if the call did not pass `Authentication`.
    """
    return _caller.get()


class Authentication(grpc.aio.ServerInterceptor):
    """Finds out who calls this project's services, and turns away who may not.

    Args:
        accounts: whose tokens are good.
        config: says where tokens are taken, and whether one is needed.
    """

    def __init__(self, accounts: Accounts, config: Config) -> None:
        self._accounts = accounts
        self._trust_proxy = config.trust_proxy
        self._nobody = anonymous_caller(config)
        self._is_said = config.anonymous is not None
        self._known: dict[bytes, tuple[Caller, float]] = {}

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Puts the question before the method's own work."""
        handler = await continuation(handler_call_details)
        method = handler_call_details.method
        if handler is None or not method.startswith("/arramon."):
            return handler

        async def answer(work: Work, request: Any, context: Context) -> Any:
            await self._admit(context, method)
            return await work(request, context)

        async def stream(work: Work, request: Any, context: Context) -> AsyncIterator[Any]:
            await self._admit(context, method)
            again = time.monotonic() + KNOWN_SECONDS
            async with aclosing(work(request, context)) as responses:
                async for response in responses:
                    if time.monotonic() >= again:
                        await self._admit(context, method, known=True)
                        again = time.monotonic() + KNOWN_SECONDS
                    yield response

        return wrapped(handler, answer, stream)

    async def _admit(self, context: Context, method: str, *, known: bool = False) -> None:
        """Notes who calls. Whom it has let in it keeps while the database is away.

        Raises:
            Unauthenticated, Forbidden: where they may not call.
        """
        try:
            caller = await self._find(context)
            if caller is None and method not in OPEN:
                raise Unauthenticated("this server wants a token, and none was sent; ask its host for one")
            _caller.set(caller or STRANGER)
        except StorageError:
            if not known:
                raise

    async def _find(self, context: Context) -> Caller | None:
        """Whom the call comes from; None where it has no token, and needs one.

        Raises:
            Unauthenticated, Forbidden: if it has one that is not taken.
        """
        sent = [str(value) for key, value in context.invocation_metadata() or () if key == "authorization"]
        if not sent:
            # Where the host said nothing, even a proxy that they forgot to tell of does not let others in.
            return self._nobody if self._is_said or is_near(context) else None
        scheme, _, token = sent[0].partition(" ")
        if len(sent) > 1 or scheme.lower() != "bearer" or not token.strip():
            raise Unauthenticated("the metadata `authorization` is not of the form `Bearer TOKEN`, once")
        if not (self._trust_proxy or is_private(context)):
            raise Forbidden(
                "tokens are taken over TLS only, and this connection is not encrypted: connect with TLS, and ask the "
                "host for another token, as this one was readable on its way"
            )
        return await self._look_up(token.strip())

    async def _look_up(self, token: str) -> Caller:
        key = sha256(token.encode()).digest()
        caller, until = self._known.get(key, (None, 0.0))
        if caller is None or until < time.monotonic():
            self._known.pop(key, None)
            caller = await asyncio.to_thread(self._accounts.caller, token)
            if len(self._known) >= KNOWN_TOKENS:
                self._known.clear()
            self._known[key] = (caller, time.monotonic() + KNOWN_SECONDS)
        return caller


def anonymous_caller(config: Config) -> Caller | None:
    """What somebody without a token is to a server; None where they may not play.

    Unless the host says otherwise, they may where only this machine can reach the server: at a loopback address or
    on a Unix socket, and with no proxy in front, through which others would come.
    """
    own = is_loopback(config.listen) and not config.trust_proxy
    if config.anonymous is None:
        return ANONYMOUS if own else None
    if not config.anonymous:
        return None
    return ANONYMOUS if own else STRANGER


def is_private(context: Context) -> bool:
    """Whether nobody on the way can read a call: it is encrypted, or does not leave this machine."""
    return context.auth_context().get("transport_security_type") == [b"ssl"] or _is_from_here(context)


def is_near(context: Context) -> bool:
    """Whether the caller is on this machine: not only a proxy on it, through which others come from anywhere."""
    proxied = {"forwarded", "via", "x-forwarded-for"} & {key for key, _ in context.invocation_metadata() or ()}
    return _is_from_here(context) and not proxied


def _is_from_here(context: Context) -> bool:
    kind, _, address = context.peer().partition(":")
    return kind == "unix" or (kind in ("ipv4", "ipv6") and is_loopback(address.replace("%5B", "[").replace("%5D", "]")))
