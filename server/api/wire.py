"""Serialization of a Play stream's responses that copies each image only once.

`Message.SerializeToString` would first copy images into messages, and then the whole response again whenever its buffer
grows. The result is a valid `PlayResponse`, because the fields of a message may come in any order.
"""

from collections.abc import Sequence
from typing import TypeAlias

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.types_pb2 import Image

Data: TypeAlias = bytes | memoryview
"""Bytes, or a view of bytes."""

Parts: TypeAlias = list[Data]
"""A serialized message, as a list of chunks."""

_LENGTH_DELIMITED = 2
"""The wire type of strings, bytes and messages."""

_EVENTS = pb.PlayResponse.EVENTS_FIELD_NUMBER
_OBSERVATION = pb.Event.OBSERVATION_FIELD_NUMBER
_DATA = Image.DATA_FIELD_NUMBER
_NUMBERS = {name: field.number for name, field in pb.Observation.DESCRIPTOR.fields_by_name.items()}


def response_of(events: Sequence[Parts]) -> bytes:
    """Return a serialized `PlayResponse` with these serialized events."""
    return b"".join(part for event in events for part in _field(_EVENTS, event))


def observation_event(message: pb.Observation, images: Sequence[tuple[str, Image, Data]]) -> Parts:
    """Return a serialized `Event` with an observation.

    Args:
        message: the observation without images.
        images: name of the field, image without its data, and data, for each image.
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
    """Return a serialized length-delimited field with this content."""
    head = _varint(number << 3 | _LENGTH_DELIMITED) + _varint(sum(map(len, content)))
    return [head, *content]


def _varint(value: int) -> bytes:
    """Return a varint: base 128, least significant digit first, highest bit set in all digits but the last."""
    digits = bytearray()
    while value > 127:
        digits.append(value & 127 | 128)
        value >>= 7
    digits.append(value)
    return bytes(digits)
