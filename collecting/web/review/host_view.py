"""What the hosts' pages share: their address, numbers in words, and rows of a collection read once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from aiohttp import web

from arramon_collecting.storage.payments.records import LedgerEntry
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import Text, Verification
from arramon_collecting.storage.work.records import Task
from arramon_collecting.web.handlers import home_address, request_texts
from arramon_server.web.page_texts import PageTexts

NOTHING = "–"
"""Shown where there is no figure."""


@dataclass(frozen=True, slots=True)
class CollectionRows:
    """The rows of a collection, oldest first."""

    tasks: Sequence[Task]
    texts: Sequence[Text]
    verifications: Sequence[Verification]
    ledger: Sequence[LedgerEntry]

    @classmethod
    def read(cls, store: Store, collection: Collection) -> "CollectionRows":
        """Read the rows of a collection."""
        name = collection.name
        return cls(
            store.tasks.all(name), store.texts.all(name), store.verifications.all(name), store.ledger.entries(name)
        )


def collection_address(request: web.Request) -> str:
    """Return the address of the collection's pages in the page's language, without a slash at its end."""
    return home_address(request).rstrip("/")


def percent(t: PageTexts, share: float | None) -> str:
    """Return a share in percent, or NOTHING."""
    return NOTHING if share is None else t.percent(share)


def score(t: PageTexts, value: float | None) -> str:
    """Return a score, or NOTHING."""
    return NOTHING if value is None else t.score(value)


def minutes(t: PageTexts, seconds: float | None) -> str:
    """Return a duration in minutes and seconds, or NOTHING."""
    if seconds is None:
        return NOTHING
    whole = round(seconds)
    return t("collect_review.minutes", minutes=t.whole(whole // 60), seconds=t.whole(whole % 60))


def common(request: web.Request, current: str) -> dict[str, Any]:
    """Return the template variables of all hosts' pages.

    Args:
        request: the request; its query may say what was done: "decided" or "changed".
        current: name of the page in the navigation; empty for a page below one.
    """
    t = request_texts(request)
    return {
        "current": current,
        "here_address": request.path,
        "message": _message(t, request),
        "minutes": lambda seconds: minutes(t, seconds),
    }


def _message(t: PageTexts, request: web.Request) -> str:
    """Return what an address says was done; states that do not exist are ignored."""
    for key, group, text in (
        ("decided", "collect_text_states", "collect_review_text.decided"),
        ("changed", "collect_worker_states", "collect_workers.changed"),
    ):
        state = f"{group}.{request.query.get(key, '')}"
        if state in t.words:
            return t(text, state=t(state))
    return ""
