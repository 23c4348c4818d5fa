"""Validation of everything that a server sends, as its messages are untrusted.

Malformed identifiers (run ids, episode ids, page tokens) are rejected, and so are numbers out of range. Texts that are
only displayed (names, notes, errors) lose characters that control a terminal, and are truncated if they are too long.
Instructions and an agent's own notes reach the agent unchanged, so that scores do not depend on the connection; code
that prints or records them makes them safe (`printable`).
"""

import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, TypeVar

import grpc
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from arramon.v1 import evaluation_pb2
from arramon_client.errors import ProtocolError
from arramon_client.printable import many_lines, one_line
from arramon_client.world import NOTE_BYTES

AnyMessage = TypeVar("AnyMessage", bound=Message)

MAX_SIDE = 1024
"""Largest side length of images, in pixels, the same as in this project's servers."""

MAX_VALUES = 8_000_000
"""Maximum total number of values in a message; a report of 20,000 episodes has fewer."""

SCORES = (-10.0, 10.0)
"""Range of scores and their differences, with intervals."""

MAX_ID = 200
"""Maximum length of an episode's id in characters."""

MAX_INSTRUCTION = 20_000
"""Maximum length of an instruction in characters."""

RUN_ID = re.compile(r"[0-9a-f]{32}")
"""Form of a run's id."""

_LARGEST_WHOLE = 2**53
"""Largest whole number that JSON holds exactly."""


def check_run_id(run_id: str, where: str = "the server sent") -> str:
    """Return a run's id after checking its form, as files are named after it.

    Raises:
        ProtocolError: if it is not 32 hexadecimal digits.
    """
    if not RUN_ID.fullmatch(run_id):
        raise ProtocolError(f"{where} the run id {_quoted(run_id)}, expected 32 hexadecimal digits")
    return run_id


def check_same_run(found: evaluation_pb2.Run, run_id: str) -> None:
    """Raise ProtocolError unless a run is the one that was requested."""
    if found.run_id != run_id:
        raise ProtocolError(f"the server sent the run {_quoted(found.run_id)}, expected {run_id}")


def details_of(error: grpc.RpcError) -> str:
    """Return the details of a failed call as one line that is safe to print; empty if there are none."""
    return one_line(error.details() or "")


def check_and_clean(message: AnyMessage) -> AnyMessage:
    """Check a message from a server, and make its texts safe to print and to store, in place.

    Raises:
        ProtocolError: if it has a malformed id, a number out of range, or too many values.
    """
    _MessageChecker().message(message)
    return message


def check_observation(message: evaluation_pb2.Observation) -> None:
    """Check an observation, faster than `check_message`; its images are checked when they are decoded.

    Raises:
        ProtocolError: as for `check_message`.
    """
    _check_length(message.instruction, "an instruction that the server sent", MAX_INSTRUCTION)
    _check_length(message.taken_note, "a note that the server sent", NOTE_BYTES)
    if message.turn not in (1, 2):
        raise ProtocolError(f"an observation has the turn {message.turn}, expected 1 or 2")
    if message.HasField("taken") and not 0 <= message.taken <= 3:
        raise ProtocolError(f"an observation has the action {message.taken}, expected 0 to 3")
    pose = message.pose
    numbers = (pose.x, pose.z, pose.heading, message.step_seconds_left, message.bank_seconds_left)
    for number in numbers:
        if not -1e9 <= number <= 1e9:  # also NaN
            raise ProtocolError(f"an observation has a pose or a time of {number}, expected a finite number")


def _check_length(text: str, where: str, most: int) -> None:
    if len(text) > most:
        raise ProtocolError(f"{where} has {len(text)} characters, expected at most {most}")


def _id(text: str, where: str) -> str:
    if len(text) > MAX_ID or one_line(text) != text:
        raise ProtocolError(f"{where} is {_quoted(text)}, expected at most {MAX_ID} visible characters")
    return text


def _run_id(text: str, where: str) -> str:
    if not RUN_ID.fullmatch(text):
        raise ProtocolError(f"{where} is {_quoted(text)}, expected 32 hexadecimal digits")
    return text


def _page_token(text: str, where: str) -> str:
    _check_length(text, where, 4096)
    return text


def _data(most: int) -> Callable[[str, str], str]:
    """Return a check for texts that are processed rather than displayed, and so are not changed."""

    def check(text: str, where: str) -> str:
        _check_length(text, where, most)
        return text

    return check


def _line(most: int) -> Callable[[str, str], str]:
    return lambda text, _: one_line(text, most)


def _lines(most: int) -> Callable[[str, str], str]:
    return lambda text, _: many_lines(text, most)


TEXTS: Mapping[str, Callable[[str, str], str]] = {
    "run_id": _run_id,
    "reproduces": _run_id,
    "episode_id": _id,
    "episode_ids": _id,
    "episodes": _id,
    "next_page_token": _page_token,
    "instruction": _data(MAX_INSTRUCTION),
    "taken_note": _data(NOTE_BYTES),
    "text": _lines(NOTE_BYTES),
    "content": _lines(64 * 1024 * 1024),
    "alphabet": _data(100_000),
    "signature": _line(10_000),
    "command": _line(5_000),
    "value": _line(1_000),
}
"""Check of a text field, by field name; `NAME` for all others."""

NAME = _line(500)

RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("Score", "Sections", "Comparison", "LanguageGap", "SeedSpread", "EpochComparison"), SCORES),
    **dict.fromkeys(("Pose", "Position", "Obstacle", "Oracle"), (-1e9, 1e9)),
    "ServerInfo.image_sizes": (1, MAX_SIDE),
    "Comparison.shown": (-1, 1),
    "Observation.turn": (1, 2),
    "Texts.longest": (0, MAX_INSTRUCTION),
    "Texts.longest_utf8": (0, 4 * MAX_INSTRUCTION),
    "Limits.steps_per_phase": (0, 1_000_000),
}
"""Smallest and largest number, by message or message and field; 0 to 2 to the power of 53 for all others."""

BYTES: Mapping[str, int] = {
    "Receipt.payload": 64 * 1024 * 1024,
    "Image.data": 64 * 1024 * 1024,
    "Epoch.statement": 100_000,
    "Actions.EpisodesEntry.value": 1_000_000,
}
"""Maximum number of bytes, by message and field; 1000 for all others."""


class _MessageChecker:
    """Recursive check of one message and the messages in it."""

    def __init__(self) -> None:
        self._left = MAX_VALUES

    def message(self, message: Message) -> None:
        if isinstance(message, evaluation_pb2.Score) and _is_plain(message):  # Most messages of a report are scores.
            self._left -= 4
            return
        name = message.DESCRIPTOR.name
        for field, value in message.ListFields():
            if _is_map(field):
                self._map(field, value)
            elif field.is_repeated:
                self._spend(len(value), name)
                self._repeated(field, value)
            elif field.message_type is not None:
                self._spend(1, name)
                self.message(value)
            else:
                self._spend(1, name)
                checked = check_value(field, value)
                if checked != value:
                    setattr(message, field.name, checked)

    def _repeated(self, field: FieldDescriptor, values: Any) -> None:
        if field.message_type is not None:
            for value in values:
                self.message(value)
            return
        checked = [check_value(field, value) for value in values]
        if checked != list(values):
            values[:] = checked

    def _map(self, field: FieldDescriptor, values: Any) -> None:
        entry = field.message_type
        assert entry is not None
        self._spend(2 * len(values), entry.name)
        key_field, value_field = entry.fields_by_name["key"], entry.fields_by_name["value"]
        for key in values:
            if isinstance(key, str):
                _id(key, f"a key of {_named(field)} that the server sent")
            else:
                check_value(key_field, key)
            if value_field.message_type is not None:
                self.message(values[key])
            else:
                check_value(value_field, values[key])

    def _spend(self, values: int, where: str) -> None:
        self._left -= values
        if self._left < 0:
            raise ProtocolError(f"a message of the server has more than {MAX_VALUES} values, the last in {where}")


def check_value(field: FieldDescriptor, value: Any) -> Any:
    """Return the value of a scalar field after checking it, with texts made safe.

    Raises:
        ProtocolError: if it is malformed or out of range.
    """
    if isinstance(value, str):
        return TEXTS.get(field.name, NAME)(value, f"{_named(field)} that the server sent")
    if isinstance(value, bytes):
        return _checked_bytes(field, value)
    if field.enum_type is not None:  # Newer servers may know more values: they are shown as unspecified.
        return value if value in field.enum_type.values_by_number else 0
    if isinstance(value, bool):
        return value
    low, high = _range(field)
    if not low <= value <= high:  # also NaN
        raise ProtocolError(f"{_named(field)} that the server sent is {value}, expected {low:g} to {high:g}")
    return value


def _checked_bytes(field: FieldDescriptor, value: bytes) -> bytes:
    name = f"{_message(field)}.{field.name}"
    if len(value) > BYTES.get(name, 1000):
        raise ProtocolError(f"{_named(field)} that the server sent has {len(value)} bytes: too many")
    if name == "Epoch.statement":
        text = value.decode("utf-8", "replace")
        if many_lines(text, len(text)).encode() != value:
            raise ProtocolError(f"{_named(field)} that the server sent is not text without control characters")
    return value


def _is_plain(score: evaluation_pb2.Score) -> bool:
    low, high = SCORES
    numbers = low <= score.mean <= high and low <= score.low <= high and low <= score.high <= high
    return numbers and _is_clean(score.metric) and not score.HasField("sections")


@lru_cache(maxsize=1024)
def _is_clean(name: str) -> bool:
    return NAME(name, "") == name


@lru_cache(maxsize=1024)
def _range(field: FieldDescriptor) -> tuple[float, float]:
    message = _message(field)
    found = RANGES.get(f"{message}.{field.name}", RANGES.get(message))
    return found or (0.0, float(_LARGEST_WHOLE))


def _is_map(field: FieldDescriptor) -> bool:
    return field.message_type is not None and field.message_type.GetOptions().map_entry


def _named(field: FieldDescriptor) -> str:
    return f"{field.name} of {_message(field)}"


def _message(field: FieldDescriptor) -> str:
    """Return the name of the message that a field belongs to."""
    assert field.containing_type is not None
    return field.containing_type.name


def _quoted(text: str) -> str:
    return repr(text[:60]) + ("..." if len(text) > 60 else "")
