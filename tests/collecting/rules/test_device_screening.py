"""Screening of devices, by tables."""

import pytest

from arramon_collecting.rules.device_screening import Device, DeviceProblem, DeviceRules, problems_of, read_device
from arramon_server.errors import BadInput

GIVEN = {"keyboard": True, "touch": False, "width": 1440, "height": 900, "frame_ms": 8.333}
DEVICE = Device(True, False, 1440, 900, 8.33)
PHONE = Device(False, True, 360, 740, 30.0)


def test_a_device_is_read() -> None:
    assert read_device(GIVEN) == DEVICE


@pytest.mark.parametrize(
    "wrong",
    [
        {"keyboard": 1}, {"touch": None}, {"width": 0}, {"width": 1e3}, {"height": True}, {"height": 10**9},
        {"frame_ms": -1}, {"frame_ms": float("nan")}, {"frame_ms": "8"}, {"frame_ms": True},
    ],
)  # fmt: skip
def test_a_wrong_report_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(BadInput, match=next(iter(wrong))):
        read_device({**GIVEN, **wrong})


@pytest.mark.parametrize(
    ("device", "rules", "expected"),
    [
        (DEVICE, DeviceRules(), []),
        (PHONE, DeviceRules(), []),
        (PHONE, DeviceRules(needs_keyboard=True, min_width=800), [DeviceProblem.NO_KEYBOARD, DeviceProblem.TOO_NARROW]),
        (Device(False, False, 800, 600, 8.0), DeviceRules(), [DeviceProblem.NO_INPUT]),
        (PHONE, DeviceRules(max_frame_ms=29.9), [DeviceProblem.TOO_SLOW]),
    ],
)
def test_devices_are_refused_with_all_reasons(
    device: Device, rules: DeviceRules, expected: list[DeviceProblem]
) -> None:
    assert problems_of(device, rules) == expected
