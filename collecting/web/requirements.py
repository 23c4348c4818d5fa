"""What a worker must do before the first verification, and the page on which it is done."""

from datetime import datetime

from arramon_collecting.rules.screening import Screening
from arramon_collecting.settings import Stage
from arramon_collecting.storage.records import VERIFY, Worker

DEVICE_PAGE, VERIFY_TEST_PAGE, PLACEMENT_PAGE = "/device", "/screening/verify", "/placement"
"""Pages of requirements, after the collection's address."""

WORKER_PAGE = "/"
"""The worker's own page, on which they agree to the terms."""


def missing_requirement(worker: Worker, stage: Stage) -> str | None:
    """Return the page of the next requirement for a verification, after the collection's address; None if all are met.

    For other stages only the device is checked here.
    """
    if worker.consented_at is None:
        return WORKER_PAGE
    if not worker.device:
        return DEVICE_PAGE
    if stage != VERIFY:
        return None
    if passed_at(worker, VERIFY) is None:
        return VERIFY_TEST_PAGE
    return PLACEMENT_PAGE if worker.placement_passed_at is None else None


def passed_at(worker: Worker, stage: Stage) -> datetime | None:
    """Return when the worker passed the screening test of a stage; None before."""
    return Screening.stored(worker.screening.get(stage, {})).passed_at
