"""Streams that end without a proper close: each is a process that joins a run, reads some messages, and leaves.

    python -m benchmarks.soak.rude_stream ADDRESS RUN WAY [TOKEN_FILE CA_FILE]

It never answers an observation, so other clients play the episodes that it claims, with unchanged results.
"""

import argparse
import os
import signal
import sys
import time
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from threading import Semaphore

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.transport.access import Access
from arramon_client.transport.channel import open_channel
from arramon_client.transport.connection import METADATA

WAYS = ("cancelled", "deadline", "connection closed", "half-closed", "killed", "not read")
"""Ways in which a stream ends."""

SEEN_BY_CLIENT = {
    "cancelled": grpc.StatusCode.CANCELLED,
    "connection closed": grpc.StatusCode.CANCELLED,
    "deadline": grpc.StatusCode.DEADLINE_EXCEEDED,
}
"""Status with which a stream ends for the client, by its way; others end without an error, or without the client."""

SEEN, SEEN_SECONDS = 3, 3.0
"""Number of server messages to read before leaving, or as many as arrive within these seconds, but at least one."""

PATIENCE = 30.0
"""Time limit of a stream, in seconds."""


def end_rudely(address: str, run: str, way: str, access: Access) -> None:
    """Join a run with a stream, and end the stream in the given way.

    Raises:
        grpc.RpcError: if the server ends the stream first.
    """
    requests = SimpleQueue[pb.PlayRequest | None]()
    opening = pb.Open(run_id=run, max_episodes=2, adopt=True)
    requests.put(pb.PlayRequest(open=opening))
    channel = open_channel(address, access, ())
    seconds = 0.5 if way == "deadline" else PATIENCE
    responses = EvaluationStub(channel).Play(iter(requests.get, None), timeout=seconds, metadata=METADATA)
    if way == "not read":
        time.sleep(1.0)
        os._exit(0)
    with ThreadPoolExecutor(1) as reader:
        seen = Semaphore(0)
        reading = reader.submit(_read, responses, seen)
        _wait(seen, reading)
        if way == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        elif way == "cancelled":
            responses.cancel()
        elif way == "connection closed":
            channel.close()
        elif way == "half-closed":
            requests.put(None)
        try:
            reading.result()
        except grpc.RpcError as error:
            if error.code() is not SEEN_BY_CLIENT.get(way):
                raise
    channel.close()


def _read(responses: Iterable[pb.PlayResponse], seen: Semaphore) -> None:
    for _response in responses:
        seen.release()


def _wait(seen: Semaphore, reading: "Future[None]") -> None:
    """Wait for the first message, or the stream's end, and then a while for `SEEN`."""
    while not seen.acquire(timeout=0.1):
        if reading.done():
            return
    until = time.monotonic() + SEEN_SECONDS
    for _ in range(SEEN - 1):
        if not seen.acquire(timeout=max(0.0, until - time.monotonic())):
            return


def main() -> int:
    """Open and end one stream; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("address", help="of the server")
    parser.add_argument("run", help="id of the run")
    parser.add_argument("way", choices=WAYS, help="in which the stream ends")
    parser.add_argument("token", nargs="?", type=Path, help="file of a participant's token")
    parser.add_argument("authority", nargs="?", type=Path, help="file of the certificate's authority")
    given = parser.parse_args()
    if given.token and not given.authority:
        parser.error("a token is sent over TLS alone: expected the file of the authority, too")
    access = Access()
    if given.token:
        access = Access(given.token.read_text().strip(), authority=given.authority.read_bytes())
    try:
        end_rudely(given.address, given.run, given.way, access)
    except grpc.RpcError as error:
        sys.stderr.write(f"{error.code().name}: {error.details()}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
