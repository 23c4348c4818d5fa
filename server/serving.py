"""Starts the server, and stops it: what `arramon-server serve` does."""

import asyncio
import logging
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress

from server.addresses import is_public
from server.config import Config
from server.episodes.splits import Split
from server.runs.database import Database
from server.sim.raster import compile_kernels, is_compiled
from server.wiring import Parts, wire

COMPILING = "compiling the camera; this is done once and takes about half a minute"
"""Announced where the fast camera has never been compiled on this machine."""

_log = logging.getLogger(__name__)


def serve(config: Config, splits: Mapping[str, Split], announce: Callable[[str], None]) -> None:
    """Serves until SIGTERM or SIGINT, and then drains: open streams end, so that their clients go to another process.

    Args:
        config: the host's settings.
        splits: what is served, by name.
        announce: told where the server listens and what it serves, once it does.

    Raises:
        ArraMonError: if the journal or the address is not right.
    """
    for doubt in doubts(config, splits):
        _log.warning("%s", doubt)
    compile_camera(config, announce)
    with closing(Database(config.journal_url, fsync=config.fsync)) as database:
        asyncio.run(_serve(config, splits, database, announce))


def doubts(config: Config, splits: Mapping[str, Split]) -> Iterator[str]:
    """What a host may not have meant, in words, where others than this machine and its network can reach the server."""
    if not is_public(config.listen):
        return
    if config.anonymous:
        yield f"anonymous is true: whoever can reach {config.listen} may play without a token"
    elif not (config.tls_certificate or config.trust_proxy):
        yield (
            f"nobody elsewhere can play at {config.listen}, as tokens are taken over TLS only: set tls_certificate and "
            "tls_key, or trust_proxy where a proxy encrypts"
        )
    hidden = ", ".join(split.name for split in splits.values() if split.hidden)
    if hidden and not (config.runs_per_day or config.runs_in_all):
        yield (
            f"the settings do not limit runs on {hidden}, and each tells a little more of what is hidden: set "
            "runs_per_day or runs_in_all"
        )


def compile_camera(config: Config, announce: Callable[[str], None]) -> None:
    """Makes sure that what draws is compiled, and announces it where that takes long."""
    if config.camera != "raster":
        return
    if not is_compiled():
        announce(COMPILING)
    compile_kernels()


async def _serve(
    config: Config, splits: Mapping[str, Split], database: Database, announce: Callable[[str], None]
) -> None:
    parts = wire(config, splits, database)
    async with parts.web as served:
        await parts.server.start()
        signals = _Signals()
        parts.engine.start()
        playing = asyncio.create_task(parts.engine.run())
        await parts.readiness.look()
        watching = asyncio.create_task(parts.readiness.watch())
        for name, address in served.items():
            announce(f"{name} at {address}")
        announce(f"listening on {parts.address}")
        # An engine that breaks down ends the process, and with it what is only in memory.
        told = asyncio.create_task(signals.first.wait())
        await asyncio.wait([playing, watching, told], return_when=asyncio.FIRST_COMPLETED)
        told.cancel()
        try:
            await _drain(parts, playing, watching, signals.second, config.drain_seconds)
        finally:
            for task in (playing, watching):
                with suppress(asyncio.CancelledError):
                    await task


async def _drain(
    parts: Parts, playing: asyncio.Task[None], watching: asyncio.Task[None], now: asyncio.Event, seconds: float
) -> None:
    """Takes no more calls, ends the streams, and waits for what is left of the calls, but no longer than it may."""
    _log.info("draining")
    watching.cancel()
    playing.cancel()
    await parts.readiness.drain()
    parts.engine.stop()
    stopping = asyncio.create_task(parts.server.stop(seconds))
    hurry = asyncio.create_task(now.wait())
    # Whatever gRPC still waits for after its own bound ends with the process.
    await asyncio.wait([stopping, hurry], timeout=seconds + 1.0, return_when=asyncio.FIRST_COMPLETED)
    _log.info("stopped" if stopping.done() else "stopped before all calls had ended")
    for task in (stopping, hurry):
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


class _Signals:
    """Notes the first SIGTERM or SIGINT, which is for draining, and the second, which is for ending at once."""

    def __init__(self) -> None:
        self.first, self.second = asyncio.Event(), asyncio.Event()
        for number in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(number, self._note)

    def _note(self) -> None:
        (self.second if self.first.is_set() else self.first).set()
