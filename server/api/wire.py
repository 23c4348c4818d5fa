"""Responses of a Play stream in their wire format, into which images are copied once.

`Message.SerializeToString` would first copy images into messages, and then the whole response again whenever its buffer
grows. The bytes are those of `PlayResponse`: a message's fields may come in any order.
"""

from collections.abc import Sequence
from typing import TypeAlias

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.types_pb2 import Image

Data: TypeAlias = bytes | memoryview
"""Bytes, or a view of bytes."""

Parts: TypeAlias = list[Data]
"""A message in its wire format, in parts."""

EncodedImage: TypeAlias = tuple[str, Image, Data]
"""The name of an image's field, the image without its data, and the data."""

_LENGTH_DELIMITED = 2
"""The wire type of strings, bytes and messages."""

_EVENTS = pb.PlayResponse.EVENTS_FIELD_NUMBER
_OBSERVATION = pb.Event.OBSERVATION_FIELD_NUMBER
_DATA = Image.DATA_FIELD_NUMBER
_NUMBERS = {name: field.number for name, field in pb.Observation.DESCRIPTOR.fields_by_name.items()}


def response_of(events: Sequence[Parts]) -> bytes:
    """Return a `PlayResponse` with these events, each in its wire format."""
    return b"".join(part for event in events for part in _field(_EVENTS, event))


def observation_event(message: pb.Observation, images: Sequence[EncodedImage]) -> Parts:
    """Return an `Event` with an observation.

    Args:
        message: the observation without images.
        images: its encoded images.
    """
    with_data = []
    for name, image, data in images:
        if len(data):
            with_data.append((_NUMBERS[name], [image.SerializeToString(), *_field(_DATA, [data])]))
        else:
            getattr(message, name).CopyFrom(image)
    parts: Parts = [message.SerializeToString()]
    for number, content in with_data:
        parts += _field(number, content)
    return _field(_OBSERVATION, parts)


def _field(number: int, content: Parts) -> Parts:
    """Return a length-delimited field with this content."""
    head = _varint(number << 3 | _LENGTH_DELIMITED) + _varint(sum(map(len, content)))
    return [head, *content]


def _varint(value: int) -> bytes:
    """Return a number in base 128, least significant digit first; all digits but the last have the highest bit set."""
    digits = bytearray()
    while value > 127:
        digits.append(value & 127 | 128)
        value >>= 7
    digits.append(value)
    return bytes(digits)
