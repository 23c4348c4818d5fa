"""What the pages of both stages' screening tests share: judging the answers, and the variables of their templates."""

from collections.abc import Mapping
from datetime import timedelta
from typing import Any

from arramon_collecting.rules.screening import CHOICES, Screening, wrong_answers
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.web.access import Visitor


def standing(visitor: Visitor, stage: str) -> Screening:
    """Return how a worker stands in the test of a stage."""
    return Screening.stored(visitor.worker.screening.get(stage, {}))


def judge(
    store: Store,
    collection: Collection,
    visitor: Visitor,
    stage: str,
    answers: Mapping[str, str],
    right: Mapping[str, str],
) -> tuple[Screening, tuple[str, ...]]:
    """Store the result of an attempt; return how the worker stands now, and the questions answered wrongly."""
    before, settings = standing(visitor, stage), collection.settings
    wrong = wrong_answers(answers, right)
    after = before.answered(
        is_right=not wrong,
        now=store.clock(),
        attempts=settings.screening_attempts,
        pause=timedelta(minutes=settings.screening_pause_minutes),
    )
    if after != before:
        store.workers.record_screening(visitor.worker.worker_id, stage, after.as_stored())
    return after, wrong


def screening_context(
    store: Store, collection: Collection, found: Screening, wrong: tuple[str, ...], right: Mapping[str, str]
) -> dict[str, Any]:
    """Return the template variables of a test."""
    attempts = collection.settings.screening_attempts
    return {
        "questions": [{"name": name, "choices": CHOICES, "right": choice} for name, choice in right.items()],
        "wrong": wrong,
        "attempts": attempts,
        "attempts_left": attempts - found.attempts,
        "paused_until": found.until if found.is_paused(store.clock()) else None,
    }
