"""Template variables of the host's page of one worker: what the worker wrote and followed, with links."""

from dataclasses import dataclass
from typing import Any

from arramon_collecting.review.figures import gold_tasks, outcome_of
from arramon_collecting.rules.keeping import succeeded
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.texts.records import Text, Verification
from arramon_collecting.web.review.host_view import CollectionRows
from arramon_collecting.web.review.review_overview import excerpt


@dataclass(frozen=True, slots=True)
class WrittenRow:
    """A text of the worker, with the beginning of its first instruction."""

    text: Text
    excerpt: str


@dataclass(frozen=True, slots=True)
class FollowedRow:
    """A verification by the worker, whether it followed the text, and whether it was of a known episode."""

    verification: Verification
    succeeded: bool
    is_gold: bool


def worker_context(collection: Collection, person: Worker, rows: CollectionRows) -> dict[str, Any]:
    """Return the template variables, newest texts and verifications first.

    Args:
        collection: the collection.
        person: the worker.
        rows: the collection's rows.
    """
    known = gold_tasks(rows.tasks)
    mine = person.worker_id
    return {
        "person": person,
        "written": [WrittenRow(one, excerpt(one)) for one in reversed(rows.texts) if one.worker_id == mine],
        "followed": [
            FollowedRow(one, succeeded(outcome_of(one), collection.settings), one.task_id in known)
            for one in reversed(rows.verifications)
            if one.worker_id == mine
        ],
        "earned": collection.settings.money(sum(one.amount_minor for one in rows.ledger if one.worker_id == mine)),
    }
