"""Whether a worker's device is fit for the tasks: keyboard, screen, speed of drawing. Pure."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from arramon_collecting.settings import DeviceRules, Stage
from arramon_server.errors import BadInput

MAX_PIXELS, MAX_MILLISECONDS = 100_000, 60_000.0
"""Limits of what a page may report."""


@dataclass(frozen=True, slots=True)
class Device:
    """What a page measured.

    Attributes:
        keyboard: whether a key was pressed.
        touch: whether the screen takes touches.
        width, height: size of the window, in CSS pixels.
        frame_ms: median time from a key to its picture, without the server, in milliseconds.
    """

    keyboard: bool
    touch: bool
    width: int
    height: int
    frame_ms: float


class DeviceProblem(StrEnum):
    """Why a device is refused."""

    NO_KEYBOARD = "no_keyboard"
    NO_INPUT = "no_input"
    TOO_NARROW = "too_narrow"
    TOO_SLOW = "too_slow"


def read_device(given: Any) -> Device:
    """Return the device of a page's message.

    Raises:
        BadInput: if a field is missing or out of range.
    """
    if not isinstance(given, dict):
        raise BadInput("the device is no JSON object")
    for name in ("keyboard", "touch"):
        if not isinstance(given.get(name), bool):
            raise BadInput(f"{name} is neither true nor false")
    for name in ("width", "height"):
        if type(given.get(name)) is not int or not 1 <= given[name] <= MAX_PIXELS:
            raise BadInput(f"{name} is no whole number from 1 to {MAX_PIXELS}")
    frame_ms: Any = given.get("frame_ms")
    if type(frame_ms) not in (int, float) or not math.isfinite(frame_ms) or not 0 <= frame_ms <= MAX_MILLISECONDS:
        raise BadInput(f"frame_ms is no number from 0 to {MAX_MILLISECONDS:g}")
    return Device(given["keyboard"], given["touch"], given["width"], given["height"], round(float(frame_ms), 2))


def problems_of(device: Device, rules: DeviceRules, stages: Collection[Stage]) -> list[DeviceProblem]:
    """Return why a device is refused for tasks of these stages; empty if it is not."""
    found = []
    if not device.keyboard and not set(stages).isdisjoint(rules.keyboard_stages):
        found.append(DeviceProblem.NO_KEYBOARD)
    elif not (device.keyboard or device.touch):
        found.append(DeviceProblem.NO_INPUT)
    if device.width < rules.min_width:
        found.append(DeviceProblem.TOO_NARROW)
    if device.frame_ms > rules.max_frame_ms:
        found.append(DeviceProblem.TOO_SLOW)
    return found
