"""Cost of gRPC alone: an empty bidirectional stream with messages as large as in play with shared memory.

    python -m benchmarks.serving.empty_stream [--seconds 3] [--request 300] [--response 3800] [--together 8]

The server answers every message with the same bytes, and the client sends the next one at once; two messages are in
flight, as in play with half of the episodes each. Client and server use gRPC like `arramon_client` and
`arramon_server.api`. No server on it can play more steps per second than this.
"""

import asyncio
import multiprocessing
import queue
import tempfile
import threading
import time
from collections.abc import AsyncIterator
from typing import Any

import grpc

from benchmarks.common import add_seconds, parser_of, positive_int, text_table
from benchmarks.serving.server import cpu_seconds

IN_FLIGHT = 2
"""Number of messages sent before the first answer."""

WARM_UP_SECONDS = 0.5


class Echo(grpc.GenericRpcHandler):
    """Answers every message of any method with the same bytes."""

    def __init__(self, answer: bytes) -> None:
        self._answer = answer

    def service(self, handler_call_details: grpc.HandlerCallDetails) -> Any:  # noqa: ARG002, part of gRPC's interface
        """Return the handler of a call."""

        async def answer(requests: AsyncIterator[bytes], context: Any) -> None:
            async for _ in requests:
                await context.write(self._answer)

        return grpc.stream_stream_rpc_method_handler(answer)


def serve(address: str, response: int, ready: Any) -> None:
    """Serve until the process is ended."""

    async def run() -> None:
        server = grpc.aio.server()
        server.add_generic_rpc_handlers((Echo(b"x" * response),))
        server.add_insecure_port(address)
        await server.start()
        ready.set()
        await server.wait_for_termination()

    asyncio.run(run())


class EchoClient:
    """A stream with a reader thread, as in `arramon_client.transport.stream`."""

    def __init__(self, address: str, request: int) -> None:
        self._request = b"y" * request
        self._outgoing: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._incoming: queue.Queue[bytes] = queue.Queue(16)
        self._channel = grpc.insecure_channel(address)
        method: Any = self._channel.stream_stream("/empty/Stream")
        self._call = method(iter(self._outgoing.get, None))
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        for _ in range(IN_FLIGHT):
            self._outgoing.put(self._request)

    def exchange(self, seconds: float) -> int:
        """Exchange messages for some time, and return how many."""
        number, end = 0, time.perf_counter() + seconds
        while time.perf_counter() < end:
            self._incoming.get()
            self._outgoing.put(self._request)
            number += 1
        return number

    def close(self) -> None:
        """End the stream."""
        self._outgoing.put(None)
        self._reader.join()
        self._channel.close()

    def _read(self) -> None:
        for answer in self._call:
            self._incoming.put(answer)


def main() -> None:
    """Run the benchmark and print its result."""
    parser = parser_of(__doc__)
    add_seconds(parser, 3.0, "duration")
    parser.add_argument(
        "--request", type=positive_int, default=300, help="bytes of a message of actions (default: %(default)s)"
    )
    parser.add_argument("--response", type=positive_int, default=3800, help="bytes of an answer (default: %(default)s)")
    parser.add_argument("--together", type=positive_int, default=8, help="steps in a message (default: %(default)s)")
    options = parser.parse_args()
    context = multiprocessing.get_context("spawn")  # gRPC must not be loaded before a fork.
    with tempfile.TemporaryDirectory() as folder:
        address, ready = f"unix:{folder}/socket", context.Event()
        process = context.Process(target=serve, args=(address, options.response, ready), daemon=True)
        process.start()
        ready.wait()
        assert process.pid is not None
        client = EchoClient(address, options.request)
        client.exchange(min(options.seconds, WARM_UP_SECONDS))
        before, own, started = cpu_seconds(process.pid), time.process_time(), time.perf_counter()
        number = client.exchange(options.seconds)
        elapsed, own = time.perf_counter() - started, time.process_time() - own
        work = cpu_seconds(process.pid) - before
        client.close()
        process.terminate()
        process.join()
    steps = number * options.together
    figures = (
        f"{number / elapsed:.0f}",
        f"{steps / elapsed:.0f}",
        f"{1e3 * work / steps:.4f}",
        f"{1e3 * own / steps:.4f}",
    )
    print(text_table(("messages/s", "steps/s", "CPU ms a step: server", "client"), [figures]))


if __name__ == "__main__":
    main()
