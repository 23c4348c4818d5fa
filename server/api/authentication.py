"""Authentication: an interceptor that derives the `Caller` of every call from its metadata."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import aclosing
from contextvars import ContextVar
from hashlib import sha256
from typing import Any

import grpc

from arramon_server.addresses import is_loopback
from arramon_server.api.interceptor import CallOrigin, Context, Continuation, Handler, HandlerFunction, wrap_handler
from arramon_server.configuration.config import Config
from arramon_server.errors import Forbidden, StorageError, Unauthenticated
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import ANONYMOUS, READER, UNAUTHENTICATED, Caller

PUBLIC_METHODS = frozenset({
    "/arramon.v1.Evaluation/GetServerInfo",
    "/arramon.v1.Evaluation/GetBreakdown",
    "/arramon.v1.Evaluation/GetReceipt",
    "/arramon.v1.Evaluation/ListNotes",
    "/arramon.v1.Leaderboard/List",
    "/arramon.v1.Leaderboard/GetEntry",
    "/arramon.v1.Leaderboard/Compare",
    "/arramon.v1.Leaderboard/Export",
    "/arramon.v1.Leaderboard/GetActions",
    "/arramon.v1.Leaderboard/ListEpochs",
    "/arramon.v1.Leaderboard/CompareEpochs",
})  # fmt: skip
"""Methods that need no token, even on a server that requires one to play."""

TOKEN_CACHE_SECONDS, TOKEN_CACHE_SIZE = 2.0, 10_000
"""Lifetime and size of the cache of looked-up tokens: a revoked token is refused after this time at the latest. Open
streams are authenticated again at this interval, when they send a response."""

_caller: ContextVar[Caller] = ContextVar("caller")


def current_caller() -> Caller:
    """Return the authenticated caller of the call that the current task handles.

    Raises:
        LookupError: if the call did not pass `Authentication`.
    """
    return _caller.get()


class Authentication(grpc.aio.ServerInterceptor):
    """Interceptor that authenticates callers of this project's services, and refuses callers without access.

    Args:
        accounts: storage of the tokens.
        config: settings that say whether a token is required, and over which connections it is accepted.
    """

    def __init__(self, accounts: Accounts, config: Config) -> None:
        self._accounts = accounts
        self._trust_proxy = config.trust_proxy
        self._anonymous = anonymous_caller(config)
        self._anonymous_is_set = config.anonymous is not None
        self._cache: dict[bytes, tuple[Caller, float]] = {}

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Wrap the call's handler so that it authenticates the caller first."""
        handler = await continuation(handler_call_details)
        method = handler_call_details.method
        if handler is None or not method.startswith("/arramon."):
            return handler

        async def answer(work: HandlerFunction, request: Any, context: Context) -> Any:
            await self._admit(CallOrigin.of(context), method)
            return await work(request, context)

        async def stream(work: HandlerFunction, request: Any, context: Context) -> AsyncIterator[Any]:
            origin = CallOrigin.of(context)
            await self._admit(origin, method)
            again = time.monotonic() + TOKEN_CACHE_SECONDS
            async with aclosing(work(request, context)) as responses:
                async for response in responses:
                    if time.monotonic() >= again:
                        await self._admit(origin, method, known=True)
                        again = time.monotonic() + TOKEN_CACHE_SECONDS
                    yield response

        return wrap_handler(handler, answer, stream)

    async def _admit(self, origin: CallOrigin, method: str, *, known: bool = False) -> None:
        """Authenticate the caller and store it for `current_caller`.

        Args:
            origin: origin of the call.
            method: full name of the called method.
            known: whether the caller was admitted before; then it stays admitted while the database is unreachable.

        Raises:
            Unauthenticated, Forbidden: if the caller may not call the method.
            StorageError: if the database cannot be reached.
        """
        try:
            public = method in PUBLIC_METHODS
            _caller.set((await self._find(origin) or READER) if public else await self.playing_caller(origin))
        except StorageError:
            if not known:
                raise

    async def playing_caller(self, origin: CallOrigin) -> Caller:
        """Return the caller of a call that is not public.

        Raises:
            Unauthenticated, Forbidden: if the caller may not play.
            StorageError: if the database cannot be reached.
        """
        caller = await self._find(origin)
        if caller is None:
            raise Unauthenticated("authentication required: no token was sent; ask the server's host for one")
        return caller

    async def _find(self, origin: CallOrigin) -> Caller | None:
        """Return the caller; None if the call needs a token and has none.

        Raises:
            Unauthenticated, Forbidden: if the call has a token that is not accepted.
        """
        sent = [str(value) for key, value in origin.metadata if key == "authorization"]
        if not sent:
            # With the default setting, a proxy that the host did not declare must not let remote clients in.
            return self._anonymous if self._anonymous_is_set or is_on_same_machine(origin) else None
        scheme, _, token = sent[0].partition(" ")
        if len(sent) > 1 or scheme.lower() != "bearer" or not token.strip():
            raise Unauthenticated("bad `authorization` metadata: expected exactly one value, `Bearer TOKEN`")
        if not (self._trust_proxy or is_confidential(origin)):
            raise Forbidden(
                "tokens are accepted over TLS only, and this connection is not encrypted: connect with TLS, and ask "
                "the host for a new token, as this one was sent unencrypted"
            )
        return await self._look_up(token.strip())

    async def _look_up(self, token: str) -> Caller:
        key = sha256(token.encode()).digest()
        caller, until = self._cache.get(key, (None, 0.0))
        if caller is None or until < time.monotonic():
            self._cache.pop(key, None)
            caller = await asyncio.to_thread(self._accounts.caller, token)
            if len(self._cache) >= TOKEN_CACHE_SIZE:
                self._cache.clear()
            self._cache[key] = (caller, time.monotonic() + TOKEN_CACHE_SECONDS)
        return caller


def anonymous_caller(config: Config) -> Caller | None:
    """Return the caller for clients without a token; None if such clients may not play.

    By default they may play if only this machine can reach the server: on a loopback address or a Unix socket, and not
    behind a proxy, which would let remote clients in.
    """
    own = config.is_for_own_machine
    if config.anonymous is None:
        return ANONYMOUS if own else None
    if not config.anonymous:
        return None
    return ANONYMOUS if own else UNAUTHENTICATED


def is_confidential(origin: CallOrigin) -> bool:
    """Return whether no third party can read a call in transit: it is encrypted, or does not leave this machine."""
    return origin.encrypted or _has_local_peer(origin)


def is_on_same_machine(origin: CallOrigin) -> bool:
    """Return whether the caller itself, not just a proxy that forwards remote calls, is on this machine."""
    proxied = {"forwarded", "via", "x-forwarded-for"} & {key for key, _ in origin.metadata}
    return _has_local_peer(origin) and not proxied


def _has_local_peer(origin: CallOrigin) -> bool:
    kind, _, address = origin.peer.partition(":")
    return kind == "unix" or (kind in ("ipv4", "ipv6") and is_loopback(address.replace("%5B", "[").replace("%5D", "]")))
