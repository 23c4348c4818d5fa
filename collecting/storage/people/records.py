"""Workers, hosts, their sign-ins and visits, as dataclasses, and the names of their states."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

WORKER, HOST = "worker", "host"
"""Roles of those who sign in."""

INVITED, ACTIVE, WORKER_PAUSED, BLOCKED, LEFT, FORGOTTEN = "invited", "active", "paused", "blocked", "left", "forgotten"
"""States of a worker."""


@dataclass(frozen=True, slots=True)
class Worker:
    """A worker, or a host who reviews.

    Attributes:
        worker_id: pseudonym, random.
        collection: name of the collection.
        role: WORKER or HOST.
        stages: the stages that the worker does.
        external_id: id on the crowd platform; None without one.
        note: note of the host, such as a name; only hosts see it.
        state: one of the states above.
        consented_at, consent_hash: when the worker agreed, and to what; None before.
        keep_texts: whether texts stay when the worker's data is deleted; None before the worker has agreed.
        screening: result of the screening test of each stage: `{"attempts": 1, "passed_at": ..., "until": ...}`.
        placement_passed_at: when the placement test was passed; None before.
        device: what was measured of the device; empty before.
        email: mail address; empty without one.
        page_language: language of the pages that the worker reads.
        created_at: when the worker was invited, or joined.
    """

    worker_id: str
    collection: str
    role: str
    stages: tuple[str, ...]
    external_id: str | None
    note: str
    state: str
    consented_at: datetime | None
    consent_hash: str | None
    keep_texts: bool | None
    screening: Mapping[str, Any]
    placement_passed_at: datetime | None
    device: Mapping[str, Any]
    email: str
    page_language: str
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Visit:
    """One session of a crowd platform's worker: completed once the study's tasks are submitted, or returned."""

    visit_id: str
    worker_id: str
    study_id: str
    session_id: str
    joined_at: datetime
    completed_at: datetime | None
    returned_at: datetime | None


@dataclass(frozen=True, slots=True)
class SignIn:
    """A sign-in of a browser.

    Attributes:
        worker_id: who signed in.
        csrf: value that every form and request that changes state repeats.
        renewed_at: when the cookie was given out.
        expires_at: when it ends.
    """

    worker_id: str
    csrf: str
    created_at: datetime
    renewed_at: datetime
    expires_at: datetime
