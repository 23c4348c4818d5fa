"""What a worker's own page shows: the next task, texts that were sent back, counts, money, the completion code."""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arramon_client.world import PHASES
from arramon_collecting.rules.keeping import Outcome, missed
from arramon_collecting.rules.licences import licence_address
from arramon_collecting.rules.payment import MILESTONE
from arramon_collecting.storage.payments.records import LedgerEntry
from arramon_collecting.storage.people.records import Visit, Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import DISCARDED, KEPT, REJECTED, SENT_BACK, Text, Verification
from arramon_collecting.storage.work.records import EXPIRED, SUBMITTED, VERIFY, WRITE, Task


@dataclass(frozen=True, slots=True)
class Completion:
    """The completion code of a crowd platform.

    Attributes:
        code: the code; None while tasks are missing.
        address: address to return to with it; empty for none.
        needed: number of tasks after which it is shown.
    """

    code: str | None
    address: str
    needed: int


def consent_view(collection: Collection, worker: Worker, language: str) -> dict[str, Any]:
    """Return the template variables of the page on which a worker agrees to the collection's text.

    Args:
        collection: the collection.
        worker: the worker.
        language: language of the page.
    """
    settings = collection.settings
    shown = settings.consent_shown(language)
    return {
        "has_mail": bool(settings.smtp.host),
        "paragraphs": [text.strip() for text in re.split(r"\n\s*\n", shown.text) if text.strip()],
        "consent_language": shown.language,
        "consent_hash": shown.hash_with(settings.licence),
        "licence_address": settings.licence_address or licence_address(settings.licence, language),
        "pays": pays(collection, worker),
        "bonuses": bonuses(collection, worker),
    }


def pays(collection: Collection, worker: Worker) -> dict[str, str]:
    """Return the payment of one task of each of a worker's stages, with the currency."""
    amounts = {WRITE: collection.settings.pay_write, VERIFY: collection.settings.pay_verify}
    return {stage: collection.settings.money(amounts[stage]) for stage in worker.stages}


def bonuses(collection: Collection, worker: Worker) -> dict[str, Any]:
    """Return the bonuses of workers who write: for a kept set, and for numbers of sets; empty without one."""
    settings = collection.settings
    if WRITE not in worker.stages:
        return {}
    return {
        "kept": settings.money(settings.pay_kept) if settings.pay_kept else "",
        "milestones": [(count, settings.money(amount)) for count, amount in settings.milestones.items() if amount],
    }


def worker_view(store: Store, collection: Collection, worker: Worker) -> dict[str, Any]:
    """Return the template variables of a worker's page, all of them about this worker only."""
    tasks, texts = store.tasks.all_of(worker.worker_id), store.texts.all_of(worker.worker_id)
    entries = store.ledger.entries_of(worker.worker_id)
    open_task = store.tasks.open_of(worker.worker_id)
    return {
        "pays": pays(collection, worker),
        "bonuses": bonuses(collection, worker),
        "open_task": open_task,
        "unfinished": [] if open_task is not None else _unfinished(store, tasks),
        "sent_back": [text for text in texts if text.state == SENT_BACK],
        "rejected": [text for text in texts if text.state == REJECTED],
        "sent": [text for text in reversed(texts) if text.instructions],
        "flags_of": {text.text_id: _flags_of(store, text) for text in texts if text.state in (DISCARDED, KEPT)},
        "missed_of": {text.text_id: _missed_of(store, collection, text) for text in texts if text.state == DISCARDED},
        "text_counts": _counts_of(texts),
        "verified": sum(task.stage == VERIFY and task.state == SUBMITTED for task in tasks),
        "earned": _earned(collection, entries),
        "total": collection.settings.money(sum(entry.amount_minor for entry in entries)),
        "completion": _completion(store, collection, worker),
        "has_mail": bool(collection.settings.smtp.host),
    }


def _unfinished(store: Store, tasks: list[Task]) -> list[Task]:
    """Return the expired tasks whose drafts can be taken up again, newest first."""
    return [task for task in reversed(tasks) if task.state == EXPIRED and store.drafts.get(task.task_id).revision]


def _flags_of(store: Store, text: Text) -> list[tuple[str, str, str]]:
    """Return the boxes that others ticked of a text, without who did: turn, phase and kind, each once."""
    ticked = {flag for walk in store.verifications.of_text(text.text_id) if walk.counts for flag in walk.flags}
    return sorted(tuple(flag.split("-", 2)) for flag in ticked)  # type: ignore[misc]


def _missed_of(store: Store, collection: Collection, text: Text) -> list[tuple[int, str]]:
    """Return the parts of a text that somebody did not find, without who: turn and phase, each once."""
    found = {part for walk in store.verifications.of_text(text.text_id) for part in _missed_in(walk, collection)}
    return sorted(found, key=lambda part: (part[0], PHASES.index(part[1])))


def _missed_in(walk: Verification, collection: Collection) -> list[tuple[int, str]]:
    """Return the parts that were not found in one verification, without turns that it gave up before."""
    if not walk.counts:
        return []
    found = missed(Outcome(walk.ndtw, walk.ptc), collection.settings)
    return [(turn, phase) for turn, phase in found if not walk.has_walk or walk.path[turn - 1]]


def _counts_of(texts: list[Text]) -> Mapping[str, int]:
    """Return the number of texts in each state, without states that none is in."""
    return Counter(text.state for text in texts)


def _earned(collection: Collection, entries: list[LedgerEntry]) -> list[dict[str, Any]]:
    """Return number and amount of the entries of each kind."""
    kinds: dict[str, list[int]] = {}
    for entry in entries:
        name = "milestone" if entry.kind.startswith(MILESTONE) else entry.kind
        kinds.setdefault(name, []).append(entry.amount_minor)
    return [
        {"kind": kind, "number": len(amounts), "amount": collection.settings.money(sum(amounts))}
        for kind, amounts in kinds.items()
    ]


def _completion(store: Store, collection: Collection, worker: Worker) -> Completion | None:
    """Return the completion code of the present visit; None for workers who did not come from a platform."""
    visit: Visit | None = store.visits.latest(worker.worker_id)
    study = collection.settings.platform.studies.get(visit.study_id) if visit is not None else None
    if study is None:
        return None
    code = store.visits.completion_code(collection, worker)
    address = study.return_url.replace("{code}", code) if code is not None else ""
    return Completion(code, address, study.tasks)
