"""A TCP relay to a server, in a thread, whose connections can be reset or frozen."""

import asyncio
import socket
import struct
import threading
from types import TracebackType


class Relay:
    """Forwards connections to a server at `host:port`, on a free port of the loopback.

    Attributes:
        address: to connect to in place of the server's.
        target: where new connections lead.
        resets: connections that were reset.
    """

    def __init__(self, target: str) -> None:
        self.target = target
        self._pairs: set[tuple[asyncio.StreamWriter, asyncio.StreamWriter]] = set()
        self.resets = 0
        self._loop = asyncio.new_event_loop()
        self._thawed = asyncio.Event()
        self._thawed.set()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server = asyncio.run_coroutine_threadsafe(
            asyncio.start_server(self._serve, "127.0.0.1", 0), self._loop
        ).result()
        self.address = f"127.0.0.1:{self._server.sockets[0].getsockname()[1]}"

    def __enter__(self) -> "Relay":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Ends every connection, and the relay."""
        asyncio.run_coroutine_threadsafe(self._close(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def reset(self) -> None:
        """Resets every connection, as a proxy does that restarts: both ends are told at once (RST)."""
        asyncio.run_coroutine_threadsafe(self._reset(), self._loop).result()

    def freeze(self) -> None:
        """Forwards nothing more and closes nothing: half-open connections, of which nobody is told."""
        self._loop.call_soon_threadsafe(self._thawed.clear)

    def thaw(self) -> None:
        """Goes on."""
        self._loop.call_soon_threadsafe(self._thawed.set)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            host, _, port = self.target.rpartition(":")
            there, back = await asyncio.open_connection(host, int(port))
        except OSError:  # the server is down: so is the way to it
            writer.close()
            return
        pair = (writer, back)
        self._pairs.add(pair)
        try:
            await asyncio.gather(self._forward(reader, back), self._forward(there, writer))
        finally:
            self._pairs.discard(pair)

    async def _forward(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while data := await reader.read(65536):
                await self._thawed.wait()
                writer.write(data)
                await writer.drain()
        except (OSError, asyncio.CancelledError):  # one end is gone, or the relay: the other is told below
            pass
        finally:
            writer.close()

    async def _reset(self) -> None:
        for pair in list(self._pairs):
            self.resets += 1
            for writer in pair:
                if not writer.is_closing():  # by its other end, which was faster
                    connection = writer.get_extra_info("socket")
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                writer.transport.abort()

    async def _close(self) -> None:
        self._server.close()
        self._thawed.set()
        await self._reset()
        others = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
