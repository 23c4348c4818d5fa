"""All checks, in the order in which they run."""

from arramon_client.conformance import (
    claims,
    images,
    information,
    limits,
    notes,
    refusals,
    results,
    resumption,
    runs,
    sensors,
    steps,
)

GROUPS = (information, runs, steps, claims, resumption, limits, notes, sensors, images, refusals, results)

CHECKS = tuple(check for group in GROUPS for check in group.CHECKS)
