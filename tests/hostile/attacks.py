"""Hostile requests without the stubs' checks: arbitrary bytes, to any method, in any order."""

import random
import socket
import string
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

import grpc
from google.protobuf.descriptor import FieldDescriptor, ServiceDescriptor
from google.protobuf.message import Message

from arramon.v1 import evaluation_pb2 as pb
from tests.serving import METADATA

SERVICE: ServiceDescriptor = pb.DESCRIPTOR.services_by_name["Evaluation"]
REQUESTS: dict[str, type[Message]] = {
    method.name: getattr(pb, method.input_type.name) for method in SERVICE.methods if method.name != "Play"
}
"""The unary methods, and what each takes."""

STRINGS = (
    "",
    "x",
    "\x00",
    "\x1b[2J",
    "../../etc/passwd",
    "' OR 1=1 --",
    "ह" * 300,
    "\u202e",
    "a" * 70_000,
    "=1+1",
    "🧿",
)
NUMBERS = (0, 1, 2, 3, 4, 7, 149, 150, 1024, 1025, 2**31 - 1, 2**31, 2**32 - 1)


PATIENCE = 120.0
"""Seconds for an answer that usually takes milliseconds: tests ask whether there is one, not how soon."""


class Attacker:
    """Calls a server with bytes, and counts the statuses of what it answers.

    Args:
        address: of the server.
        seed: of everything random.
    """

    def __init__(self, address: str, seed: int) -> None:
        self.random = random.Random(seed)
        self.statuses: Counter[grpc.StatusCode] = Counter()
        self.details: set[str] = set()
        self.streams_unread = 0
        # A connection of its own: channels of one process share one otherwise.
        self._channel = grpc.insecure_channel(address, options=[("grpc.use_local_subchannel_pool", 1)])

    def close(self) -> None:
        self._channel.close()

    def unary(self, method: str, data: bytes, metadata: Any = METADATA) -> bytes | None:
        """Calls a method that takes one message; None where it is refused."""
        call: Any = self._channel.unary_unary(f"/{SERVICE.full_name}/{method}")
        try:
            answer: bytes = call(data, metadata=metadata, timeout=PATIENCE)
        except grpc.RpcError as error:
            self.note(error)
            return None
        self.statuses[grpc.StatusCode.OK] += 1
        return answer

    def stream(self, messages: Iterable[bytes], timeout: float = PATIENCE) -> Any:
        """Opens a Play stream that sends these; an iterator over what comes back."""
        call: Any = self._channel.stream_stream(f"/{SERVICE.full_name}/Play")
        return call(iter(messages), metadata=METADATA, timeout=timeout)

    def play(self, messages: Iterable[bytes]) -> list[bytes]:
        """All that a stream of these is answered."""
        answers = []
        try:
            answers.extend(self.stream(messages))
        except grpc.RpcError as error:
            self.note(error)
        else:
            self.statuses[grpc.StatusCode.OK] += 1
        return answers

    def note(self, error: grpc.RpcError) -> None:
        self.statuses[error.code()] += 1
        self.details.add(error.details() or "")

    def bytes_(self, longest: int = 200) -> bytes:
        return self.random.randbytes(self.random.randrange(longest))

    def mutated(self, data: bytes) -> bytes:
        """A message with some of its bytes changed, left out, or doubled."""
        changed = bytearray(data)
        for _ in range(self.random.randrange(1, 4)):
            place = self.random.randrange(len(changed) + 1)
            match self.random.randrange(3):
                case 0:
                    changed[place : place + 1] = self.random.randbytes(1)
                case 1:
                    del changed[place : place + self.random.randrange(4)]
                case _:
                    changed[place:place] = changed[place : place + self.random.randrange(8)]
        return bytes(changed)

    def filled(self, message: Message, depth: int = 3) -> Message:
        """A message with odd values in some of its fields."""
        for field in message.DESCRIPTOR.fields:
            if self.random.random() < 0.3 or (field.message_type and not depth):
                continue
            if field.is_repeated:
                self._fill_repeated(message, field, depth)
            elif field.message_type:
                self.filled(getattr(message, field.name), depth - 1)
            else:
                setattr(message, field.name, self._value(field))
        return message

    def _fill_repeated(self, message: Message, field: Any, depth: int) -> None:
        values = getattr(message, field.name)
        for _ in range(self.random.choice((0, 1, 3, 50))):
            if field.message_type:
                self.filled(values.add(), depth - 1)
            else:
                values.append(self._value(field))

    def _value(self, field: Any) -> Any:
        if field.type == FieldDescriptor.TYPE_STRING:
            return self.random.choice((*STRINGS, "".join(self.random.choices(string.printable, k=20))))
        if field.type == FieldDescriptor.TYPE_BOOL:
            return self.random.random() < 0.5
        if field.type == FieldDescriptor.TYPE_ENUM:  # open enumerations: any number can travel
            return self.random.choice((0, 1, 2, 3, 4, 99, 2**31 - 1))
        return self.random.choice(NUMBERS)


def play_message(act: Iterable[pb.Act] = (), **opening: Any) -> bytes:
    """A stream's message: `open` where something of it is given, otherwise a batch of acts."""
    if opening:
        return pb.PlayRequest(open=pb.Open(**opening)).SerializeToString()
    return pb.PlayRequest(actions=pb.ActionBatch(acts=act)).SerializeToString()


def sockets(address: str, first_words: Iterable[bytes]) -> Iterator[socket.socket]:
    """Bare connections, each with its first words said."""
    host, _, port = address.rpartition(":")
    for words in first_words:
        connection = socket.create_connection((host, int(port)), timeout=PATIENCE)
        if words:
            connection.sendall(words)
        yield connection
