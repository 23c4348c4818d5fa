"""What a worker has to do before a task: agree, show what the device can do, pass the tests."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Any


class Step(StrEnum):
    """The next page of a worker; the value is its address below the collection's."""

    CONSENT = "consent"
    DEVICE = "device"
    SCREENING = "screening"
    PLACEMENT = "placement"
    TASK = "task"


def next_step(
    stage: str,
    *,
    consented: bool,
    device: Mapping[str, Any],
    screening: Mapping[str, Any],
    placement_passed: bool,
) -> Step:
    """Return the first thing that is missing before a task of a stage.

    Args:
        stage: "write" or "verify".
        consented: whether the worker has agreed to the collection's text.
        device: what was measured; empty before, and with a list "problems" if the device is not fit.
        screening: result of the screening test of each stage, with the time "passed_at".
        placement_passed: whether the placement test was passed, which verifiers need.
    """
    if not consented:
        return Step.CONSENT
    if not device or device.get("problems"):
        return Step.DEVICE
    if not screening.get(stage, {}).get("passed_at"):
        return Step.SCREENING
    if stage == "verify" and not placement_passed:
        return Step.PLACEMENT
    return Step.TASK
