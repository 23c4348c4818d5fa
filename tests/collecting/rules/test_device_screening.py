"""Screening of devices, by tables."""

import pytest

from arramon_collecting.rules.device_screening import Device, DeviceProblem, problems_of, read_device
from arramon_collecting.settings import DeviceRules, Stage
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
    ("device", "rules", "stages", "expected"),
    [
        (DEVICE, DeviceRules(), ["write", "verify"], []),
        (PHONE, DeviceRules(), ["write", "verify"], []),
        (PHONE, DeviceRules(keyboard_stages=("write",)), ["verify"], []),
        (
            PHONE,
            DeviceRules(keyboard_stages=("write",), min_width=800),
            ["write", "verify"],
            [DeviceProblem.NO_KEYBOARD, DeviceProblem.TOO_NARROW],
        ),
        (Device(False, False, 800, 600, 8.0), DeviceRules(), ["verify"], [DeviceProblem.NO_INPUT]),
        (PHONE, DeviceRules(max_frame_ms=50), ["verify"], []),
        (Device(True, True, 360, 740, 50.1), DeviceRules(max_frame_ms=50), ["verify"], [DeviceProblem.TOO_SLOW]),
    ],
)
def test_devices_are_refused_with_all_reasons(
    device: Device, rules: DeviceRules, stages: list[Stage], expected: list[DeviceProblem]
) -> None:
    assert problems_of(device, rules, stages) == expected
