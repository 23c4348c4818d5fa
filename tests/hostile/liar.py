"""A server that answers every call of the protocol with a full message, and lies in one field of it."""

import contextlib
import math
import queue
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import grpc
import numpy as np
import simplejpeg
import zstandard
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message
from google.protobuf.message_factory import GetMessageClass

from arramon.v1 import PROTOCOL, evaluation_pb2, leaderboard_pb2, types_pb2

pb = evaluation_pb2

Field = Any
"""A field's descriptor: its stubs know several classes of these."""

RUN, EPISODE, SPLIT = "5a" * 16, "e1", "val_seen"

SIZE = 16
"""Side length of images in pixels."""

METRICS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD@CTC-3", "PTC@CTC-3", "rPOD", "PTC")

TEXTS = (
    "../../../escaped",
    "/tmp/arramon-escaped",
    "a\x00b",
    "\x1b]0;title\x07\x1b[2J\x9b31m",
    "x" * 1_000_000,
    "\u202egnp.\u2066exe\u200b\U000e0041",
    "[/bold][link=file:///etc/passwd]here",
    "a" + "\u0301" * 2000,
    "line\r\nerror: forged\n\x0bmore",
    "",
)
BYTES = (b"", b"\x00", b"\xff\xfe\x1b[2J", b"[" * 200_000, b"x" * 1_000_000, b'{"a":' * 200_000)
FLOATS = (math.nan, math.inf, -math.inf, -1.0, 1e308, -1e-320)
WHOLES = (0, 1, -1, 2**31 - 1, 2**32 - 1, 2**53 + 1, 2**63 - 1, 2**64 - 1, -(2**31), -(2**63))
ENUMS = (0, 99, -1)


@dataclass(frozen=True)
class Lie:
    """A field of a message that is false wherever the message occurs.

    Attributes:
        message: name of the message.
        field: name of the field.
        value: what it holds: its only value if it is repeated, and its only key and value if it is a map.
    """

    message: str
    field: str
    value: Any

    def __str__(self) -> str:
        shown = repr(self.value)
        return f"{self.message}.{self.field}={shown[:30]}"

    def tell(self, message: Message) -> int:
        """Put the false value into a message and all that it contains; return the number of times."""
        told = 0
        for field, value in message.ListFields():
            if field.message_type is None:
                continue
            for each in _contained(field, value):
                told += self.tell(each)
        if message.DESCRIPTOR.name == self.message:
            self._set(message)
            told += 1
        return told

    def _set(self, message: Message) -> None:
        field = message.DESCRIPTOR.fields_by_name[self.field]
        if is_map(field):
            found = getattr(message, self.field)
            if isinstance(self.value, str):  # a key
                if _values(field).message_type:
                    found[self.value].CopyFrom(full(GetMessageClass(_values(field).message_type)))
                else:
                    found[self.value] = next(iter(found.values()))
            else:
                for key in found:
                    found[key] = self.value
        elif field.is_repeated:
            del getattr(message, self.field)[:]
            getattr(message, self.field).append(self.value)
        else:
            setattr(message, self.field, self.value)


def is_map(field: Field) -> bool:
    return bool(field.message_type is not None and field.message_type.GetOptions().map_entry)


def _values(field: Field) -> Field:
    assert field.message_type is not None
    return field.message_type.fields_by_name["value"]


def _contained(field: Field, value: Any) -> Iterable[Message]:
    """The messages in the value of a field."""
    if is_map(field):
        return value.values() if _values(field).message_type is not None else ()
    return value if field.is_repeated else (value,)


SERVICES = (
    evaluation_pb2.DESCRIPTOR.services_by_name["Evaluation"],
    leaderboard_pb2.DESCRIPTOR.services_by_name["Leaderboard"],
)

ANSWERS: dict[str, type[Message]] = {
    method.name: GetMessageClass(method.output_type) for service in SERVICES for method in service.methods
}
"""Name of a method -> what it returns."""


def messages_in(descriptor: Any) -> set[str]:
    """The names of a message and all that it may contain."""
    found, waiting = {descriptor.name: descriptor}, [descriptor]
    while waiting:
        for field in waiting.pop().fields:
            inner = field.message_type
            if inner is not None and inner.name not in found:
                found[inner.name] = inner
                waiting.append(inner)
    return {name for name, each in found.items() if not each.GetOptions().map_entry}


def lies(message: Any) -> Iterator[Lie]:
    """Every false value for every field of a message that is no message itself."""
    for field in message.fields:
        of = field
        if is_map(field):
            yield from (Lie(message.name, field.name, text) for text in TEXTS)
            of = _values(field)
        if of.message_type is None:
            yield from (Lie(message.name, field.name, value) for value in _false_values(of))


def _false_values(field: Field) -> tuple[Any, ...]:
    if field.enum_type is not None:
        return ENUMS
    whole = {
        FieldDescriptor.CPPTYPE_INT32: (-(2**31), 2**31),
        FieldDescriptor.CPPTYPE_INT64: (-(2**63), 2**63),
        FieldDescriptor.CPPTYPE_UINT32: (0, 2**32),
        FieldDescriptor.CPPTYPE_UINT64: (0, 2**64),
    }.get(field.cpp_type)
    if whole is not None:
        return tuple(value for value in WHOLES if whole[0] <= value < whole[1])
    if field.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE:
        return FLOATS
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return (True, False)
    return BYTES if field.type == FieldDescriptor.TYPE_BYTES else TEXTS


TRUE: dict[str, Any] = {
    "run_id": RUN,
    "reproduces": RUN,
    "episode_id": EPISODE,
    "episode_ids": EPISODE,
    "Correction.episodes": EPISODE,
    "split": SPLIT,
    "ServerInfo.protocol": PROTOCOL,
    "ServerInfo.image_sizes": SIZE,
    "ServerInfo.encodings": types_pb2.ENCODING_RAW,
    "ServerInfo.max_episodes_per_stream": 8,
    "ServerInfo.addresses": "127.0.0.1:1",
    "Split.name": SPLIT,
    "Split.hidden": False,
    "Split.sensors": "rgb",
    "Run.language": "en",
    "Run.agent": "liars_agent",
    "Run.state": pb.RUN_STATE_RUNNING,
    "Run.episodes": 1,
    "Run.episodes_ended": 0,
    "Run.sensors": "rgb",
    "Row.name": "total",
    "Observation.turn": 1,
    "Observation.step": 0,
    "EpisodeStarted.step": 0,
    "Opened.encoding": types_pb2.ENCODING_RAW,
    "TurnGroup.low": 1,
    "next_page_token": "",
    "statement": b'{"format":"x"}',
    "Score.mean": 0.5,
    "Score.low": 0.25,
    "Score.high": 0.75,
    "Comparison.p": 0.5,
    "Texts.alphabet": "abcdefghijklmnopqrstuvwxyz ",
    "Texts.longest": 20,
    "Texts.longest_utf8": 20,
    "Limits.steps_per_phase": 9,
    "Quota.runs_per_day": 0,
    "Quota.runs_in_all": 0,
    "Quota.runs_at_once": 0,
}
"""Field, or message and field -> its true value, where the one by its type would not do."""


def full(message: type[Message], depth: int = 6) -> Any:
    """A message of this type with a true value in every field."""
    made, fields = message(), list[Any](message.DESCRIPTOR.fields)
    for field in fields:
        name = f"{message.DESCRIPTOR.name}.{field.name}"
        if name == "Observation.taken":  # It is no history.
            continue
        if is_map(field):
            inner = _values(field)
            found = getattr(made, field.name)
            if inner.message_type is not None:
                found["en"].CopyFrom(full(GetMessageClass(inner.message_type), depth - 1))
            else:
                found["en"] = TRUE.get(name, b"" if inner.type == FieldDescriptor.TYPE_BYTES else 1)
        elif field.message_type is not None:
            if depth:
                child = full(GetMessageClass(field.message_type), depth - 1)
                if field.is_repeated:
                    getattr(made, field.name).append(child)
                elif field.containing_oneof is None:
                    getattr(made, field.name).CopyFrom(child)
        else:
            value = TRUE.get(name, TRUE.get(field.name, _true_value(field)))
            if field.is_repeated:
                getattr(made, field.name).append(value)
            else:
                setattr(made, field.name, value)
    if isinstance(made, pb.Row):
        made.ClearField("scores")
        made.scores.extend(pb.Score(metric=m, mean=0.5, low=0.25, high=0.75) for m in METRICS)
        made.scores[0].sections.CopyFrom(full(pb.Sections))
    if isinstance(made, types_pb2.Image):
        made.CopyFrom(types_pb2.Image(height=SIZE, width=SIZE, encoding=types_pb2.ENCODING_RAW))
    return made


def _true_value(field: Field) -> Any:
    if field.cpp_type == FieldDescriptor.CPPTYPE_STRING:
        return b"\x01" * 32 if field.type == FieldDescriptor.TYPE_BYTES else field.name
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return True
    return 0.5 if field.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE else 1


def image(channels: int) -> types_pb2.Image:
    data = bytes(SIZE * SIZE * channels)
    return types_pb2.Image(height=SIZE, width=SIZE, encoding=types_pb2.ENCODING_RAW, data=data)


PIXELS = np.zeros((8192, 8192, 3), np.uint8)


BOMBS = (
    "zstd",
    "zstd of another size",
    "jpeg",
    "jpeg of another size",
    "progressive jpeg",
    "padded jpeg",
    "nothing",
    "shared",
)


@cache
def bombs() -> dict[str, types_pb2.Image]:
    """Images of few bytes that become many, or take long, by the names in `BOMBS`."""
    zero = zstandard.ZstdCompressor(level=19).compress(bytes(8192 * 8192 * 3))
    small = np.zeros((SIZE, SIZE, 3), np.uint8)
    large = simplejpeg.encode_jpeg(PIXELS, quality=50)
    progressive = simplejpeg.encode_jpeg(small).replace(b"\xff\xc0", b"\xff\xc2")
    zstd, jpeg = types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG
    return {
        "zstd": types_pb2.Image(height=8192, width=8192, encoding=zstd, data=zero),
        "zstd of another size": types_pb2.Image(height=SIZE, width=SIZE, encoding=zstd, data=zero),
        "jpeg": types_pb2.Image(height=8192, width=8192, encoding=jpeg, data=large),
        "jpeg of another size": types_pb2.Image(height=SIZE, width=SIZE, encoding=jpeg, data=large),
        "progressive jpeg": types_pb2.Image(height=SIZE, width=SIZE, encoding=jpeg, data=progressive),
        "padded jpeg": types_pb2.Image(height=SIZE, width=SIZE, encoding=jpeg, data=bytes(progressive) * 100),
        "nothing": types_pb2.Image(height=0, width=SIZE, encoding=types_pb2.ENCODING_RAW),
        "shared": types_pb2.Image(height=SIZE, width=SIZE, encoding=types_pb2.ENCODING_SHARED, place=2**63),
    }


def serialize(message: Message) -> bytes:
    return message.SerializeToString()


class Liar(grpc.GenericRpcHandler):
    """Handler of every method.

    Attributes:
        lie: the present lie; None for none.
        told: the number of times that it was told.
        refusal: the status and details with which every call but GetServerInfo is refused; None for none.
        image: of every observation; None for an honest one.
        events: sent in place of the honest ones after `opened`; None for these.
        finished: whether runs are over when they are created.
        receipt: the receipt that GetReceipt returns.
    """

    def __init__(self) -> None:
        self.lie: Lie | None = None
        self.told = 0
        self.refusal: tuple[grpc.StatusCode, str] | None = None
        self.image: types_pb2.Image | None = None
        self.events: list[pb.Event] | None = None
        self.finished = False
        self.agent = "liars_agent"
        self.receipt: pb.Receipt | None = None

    def service(self, details: grpc.HandlerCallDetails) -> Any:
        method = details.method.rpartition("/")[2]
        if method == "Play":
            return grpc.stream_stream_rpc_method_handler(self._play, pb.PlayRequest.FromString, serialize)

        def answer(request: bytes, context: Any) -> Message:
            if self.refusal is not None and method != "GetServerInfo":
                context.abort(*self.refusal)
            return self.answer(method)

        return grpc.unary_unary_rpc_method_handler(answer, None, serialize)

    def answer(self, method: str) -> Message:
        if method == "GetReceipt" and self.receipt is not None:
            message: Any = self.receipt
        else:
            message = full(ANSWERS[method])
        if isinstance(message, pb.Run):
            message.agent = self.agent
            message.state = pb.RUN_STATE_COMPLETE if self.finished else pb.RUN_STATE_RUNNING
            if method == "GetRun":  # As it was started.
                message.ClearField("agent_arguments")
                message.ClearField("code")
        self._tell(message)
        return message  # type: ignore[no-any-return]

    def _tell(self, message: Message) -> None:
        if self.lie is not None:
            self.told += self.lie.tell(message)

    def _play(self, requests: Iterator[pb.PlayRequest], context: Any) -> Iterator[pb.PlayResponse]:
        acts = self._acts(requests, context)
        run = full(pb.Run)
        run.agent = self.agent
        opened = pb.Opened(run=run, encoding=types_pb2.ENCODING_RAW, image_size=SIZE)
        opened.labels.add(kind="nothing")
        opened.shared.CopyFrom(full(types_pb2.SharedMemory))
        yield self._response([pb.Event(opened=opened)])
        if self.events is not None:
            yield self._response(self.events)
            return
        started = pb.EpisodeStarted(episode_id=EPISODE, language="en", split=SPLIT, oracle=full(pb.Oracle))
        yield self._response([pb.Event(episode_started=started), self._observation(0)])
        for step, _ in enumerate(acts, start=1):
            if step == 2:
                break
            ended = pb.PhaseEnded(episode_id=EPISODE, turn=1, phase=types_pb2.PHASE_NAVIGATION)
            yield self._response([pb.Event(phase_ended=ended), self._observation(step)])
        run.state = pb.RUN_STATE_COMPLETE
        problem = pb.Problem(code=pb.Problem.CODE_NOT_YOUR_EPISODE, message="not yours", episode_id="e9", step=1)
        yield self._response([pb.Event(problem=problem)])
        end = pb.EpisodeEnded(episode_id=EPISODE, cause=types_pb2.CAUSE_AGENT_FINISHED, episodes_ended=1)
        yield self._response([pb.Event(episode_ended=end), pb.Event(run_ended=pb.RunEnded(run=run))])

    def _acts(self, requests: Iterator[pb.PlayRequest], context: Any) -> Iterator[pb.PlayRequest]:
        """What the client answers. The stream is aborted if it does not: it may wait for what a lie has left out."""
        next(requests)
        arrived: queue.SimpleQueue[pb.PlayRequest] = queue.SimpleQueue()

        def read() -> None:
            with contextlib.suppress(grpc.RpcError):
                for request in requests:
                    arrived.put(request)

        threading.Thread(target=read, daemon=True).start()
        looks = 0
        while context.is_active() and looks < (1200 if self.lie is None else 2):
            try:
                yield arrived.get(timeout=0.05)
                looks = 0
            except queue.Empty:
                looks += 1
        context.abort(grpc.StatusCode.FAILED_PRECONDITION, "nothing was answered")

    def _observation(self, step: int) -> pb.Event:
        seen = pb.Observation(
            episode_id=EPISODE, step=step, turn=1, phase=types_pb2.PHASE_NAVIGATION, instruction="go", phase_step=step,
            steps_left=9, rgb=self.image or image(3), depth=image(2), pose=full(types_pb2.Pose),
            segmentation=image(2), step_seconds_left=9.0, bank_seconds_left=9.0,
        )  # fmt: skip
        return pb.Event(observation=seen)

    def _response(self, events: list[pb.Event]) -> pb.PlayResponse:
        response = pb.PlayResponse(events=events)
        self._tell(response)
        return response


@contextmanager
def lying(liar: Liar) -> Iterator[str]:
    """Serve until the end of the context; yield the address."""
    pool = ThreadPoolExecutor(8)
    server = grpc.server(pool, options=[("grpc.max_send_message_length", -1)])
    server.add_generic_rpc_handlers((liar,))
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    try:
        yield f"127.0.0.1:{port}"
    finally:
        server.stop(None).wait()
        pool.shutdown()
