"""Startup, startup checks and draining of a server process, for `arramon-server serve`."""

import asyncio
import gc
import logging
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress

from arramon_server.configuration.config import Config
from arramon_server.episodes.epoch_statement import SECRETS_FOLDER
from arramon_server.episodes.splits import SECRET_FILE, Split, split_folder
from arramon_server.errors import BadInput
from arramon_server.private_files import check_private_file, check_private_folder
from arramon_server.process.server_parts import ServerParts, create_parts
from arramon_server.runs.accounts.quotas import LIMITS
from arramon_server.runs.storage.database import Database
from arramon_server.sim.raster.camera import compile_kernels, is_compiled

COMPILING = "compiling the camera (only once; takes about half a minute)"
"""Message if the fast camera has never been compiled on this machine."""

_log = logging.getLogger(__name__)


def serve(config: Config, splits: Mapping[str, Split], announce: Callable[[str], None]) -> None:
    """Serve until SIGTERM or SIGINT, then drain: end the open streams, so that their clients move to another process.

    Args:
        config: the host's settings.
        splits: the splits served, by name.
        announce: called with a line for each address, once the server listens there.

    Raises:
        ArraMonError: if the journal cannot be used, or an address cannot be listened on.
    """
    for warning in settings_warnings(config, splits):
        _log.warning("%s", warning)
    compile_camera(config, announce)
    gc.freeze()  # Garbage collection, which pauses all streams, then skips compiled kernels and modules.
    with closing(Database(config.journal_url, fsync=config.fsync)) as database:
        asyncio.run(_serve(config, splits, database, announce))


def settings_warnings(config: Config, splits: Mapping[str, Split]) -> Iterator[str]:
    """Yield warnings about settings that a host may not have intended, if other machines can reach the server.

    Behind a proxy or in a private network, other machines can reach the server at any address.
    """
    if config.is_for_own_machine:
        return
    if config.anonymous:
        proxy = " or the proxy in front of it" if config.trust_proxy else ""
        yield f"anonymous is true: anyone who can reach {config.listen}{proxy} may play without a token"
    elif not (config.tls_certificate or config.trust_proxy):
        yield (
            f"clients on other machines cannot play at {config.listen}, as tokens are accepted over TLS only: set "
            "tls_certificate and tls_key, or trust_proxy if a proxy encrypts"
        )
    hidden = [split.name for split in splits.values() if split.hidden]
    unlimited = [name for name in hidden if config.runs_per_day.of(name) == 0 and not config.runs_in_all.of(name)]
    if unlimited:
        yield (
            f"runs on {', '.join(unlimited)} are not limited, and each reveals a little of the hidden data: "
            f"set runs_per_day or runs_in_all, for example --runs-per-day {unlimited[0]}=3"
        )


def check_limited_splits(config: Config, splits: Mapping[str, Split]) -> None:
    """Check that limits and closing times name only served splits: those of a misspelt split would have no effect.

    Raises:
        BadInput: if there is no split of that name; the message lists those that exist.
    """
    for limit in (*LIMITS, "closes"):
        for name in getattr(config, limit).splits:
            if name not in splits:
                existing = ", ".join(splits) or "none"
                raise BadInput(
                    f"{limit} names the split {name!r}, which is not in {config.data}; existing splits: {existing}"
                )


def check_secrets(config: Config, splits: Mapping[str, Split]) -> None:
    """Check that no other user of this machine can read the host's secrets and hidden splits.

    Raises:
        BadFile: if others can read one; the message gives the command that corrects this.
    """
    check_private_file(config.data / SECRET_FILE)
    for path in sorted((config.data / SECRETS_FOLDER).glob("*")):
        check_private_file(path)
    for split in splits.values():
        if split.hidden:
            check_private_folder(split_folder(config.data, split.name))


def compile_camera(config: Config, announce: Callable[[str], None]) -> None:
    """Compile the camera if necessary; announce it if this takes long."""
    if config.camera != "raster":
        return
    if not is_compiled():
        announce(COMPILING)
    compile_kernels()


async def _serve(
    config: Config, splits: Mapping[str, Split], database: Database, announce: Callable[[str], None]
) -> None:
    signals = _Signals()
    parts = create_parts(config, splits, database)
    async with parts.web as served:
        await parts.server.start()
        parts.engine.start()
        engine_task = asyncio.create_task(parts.engine.run())
        await parts.readiness.check()
        readiness_task = asyncio.create_task(parts.readiness.watch())
        for name, address in served.items():
            announce(f"{name} at {address}")
        announce(f"listening on {parts.address}")
        # If the engine fails, the process ends, and with it all state that is only in memory.
        signalled = asyncio.create_task(signals.first.wait())
        await asyncio.wait([engine_task, readiness_task, signalled], return_when=asyncio.FIRST_COMPLETED)
        signalled.cancel()
        try:
            await _drain(parts, engine_task, readiness_task, signals.second, config.drain_seconds)
        finally:
            for task in (engine_task, readiness_task):
                with suppress(asyncio.CancelledError):
                    await task


async def _drain(
    parts: ServerParts,
    engine_task: asyncio.Task[None],
    readiness_task: asyncio.Task[None],
    now: asyncio.Event,
    seconds: float,
) -> None:
    """Refuse new calls, end the streams, and wait up to `seconds` for open calls to end, or until `now` is set."""
    _log.info("draining")
    readiness_task.cancel()
    engine_task.cancel()
    await parts.readiness.drain()
    parts.engine.stop()
    stopping = asyncio.create_task(parts.server.stop(seconds))
    second_signal = asyncio.create_task(now.wait())
    # Calls that gRPC still waits for after its own limit end with the process.
    await asyncio.wait([stopping, second_signal], timeout=seconds + 1.0, return_when=asyncio.FIRST_COMPLETED)
    _log.info("stopped" if stopping.done() else "stopped before all calls had ended")
    for task in (stopping, second_signal):
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


class _Signals:
    """Events for SIGTERM and SIGINT: the first signal starts draining, the second one ends the process at once."""

    def __init__(self) -> None:
        self.first, self.second = asyncio.Event(), asyncio.Event()
        for number in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(number, self._note)

    def _note(self) -> None:
        (self.second if self.first.is_set() else self.first).set()
