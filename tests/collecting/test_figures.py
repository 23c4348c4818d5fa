"""Figures of a collection and its workers, from literal rows."""

from datetime import UTC, date, datetime, timedelta

import pytest

from arramon_collecting.review.figures import figures_of_workers, overview_of
from arramon_collecting.rules.agreement import Agreement
from arramon_collecting.settings import Settings
from arramon_collecting.storage.payments.records import LedgerEntry
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.texts.records import Text, Verification
from arramon_collecting.storage.work.records import Task

NOON = datetime(2026, 5, 1, 12, tzinfo=UTC)
STREET = ((0.0, 0.0), (0.0, 1.0))
CELL, ELSEWHERE = (2, 1, 2), (3, 1, 2)
SETTINGS = Settings()


def worker(worker_id: str) -> Worker:
    stages = ("write", "verify")
    return Worker(
        worker_id, "people", "worker", stages, None, "", "active", NOON, "", True, {}, NOON, {}, "", "", NOON
    )  # fmt: skip


def task(
    task_id: str,
    stage: str,
    worker_id: str,
    *,
    state: str = "submitted",
    seconds: float = 60.0,
    gold: bool = False,
    day: int = 0,
) -> Task:
    end = NOON + timedelta(days=day)
    return Task(task_id, "people", stage, worker_id, "e", "t", gold, state, NOON, NOON, end, seconds, None, None, {})


def text(text_id: str, worker_id: str, state: str, **evidence: object) -> Text:
    return Text(text_id, "people", None, worker_id, "e", "hi", (), (), evidence, state, 1, (), "", NOON, None, None)


def walked(
    task_id: str, text_id: str, worker_id: str, *flags: str, ptc: float = 1.0, counts: bool = True
) -> Verification:
    cells = (CELL if ptc else ELSEWHERE, CELL)
    return Verification(
        task_id, "people", text_id, "e", worker_id, "r", (0.5, 0.7), (ptc, 1.0), cells, (STREET, STREET), flags, 60.0,
        counts, NOON,
    )  # fmt: skip


TASKS = [
    task("w1", "write", "ann", seconds=300.0), task("w2", "write", "ann", seconds=500.0, day=1),
    task("v1", "verify", "bob"), task("v2", "verify", "cid", seconds=100.0), task("v3", "verify", "bob", gold=True),
    task("v4", "verify", "cid", state="returned"), task("v5", "verify", "bob", seconds=5.0),
]  # fmt: skip
TEXTS = [text("t1", "ann", "kept"), text("t2", "ann", "discarded", pasted=True)]
WALKS = [
    walked("v1", "t1", "bob", "1-navigation-unclear"), walked("v2", "t1", "cid", ptc=0.0), walked("v3", "g", "bob"),
    walked("v5", "t2", "bob", counts=False),
]  # fmt: skip
LEDGER = [
    LedgerEntry("1", "people", "ann", "write", "t1", 100, "USD", NOON),
    LedgerEntry("2", "people", "ann", "kept", "t1", 10, "USD", NOON),
    LedgerEntry("3", "people", "bob", "verify", "v1", 20, "USD", NOON),
    LedgerEntry("4", "people", "cid", "verify", "v2", 20, "USD", NOON),
]


def test_overview() -> None:
    found = overview_of(TASKS, TEXTS, WALKS, LEDGER, SETTINGS)
    assert found.texts == {"kept": 1, "discarded": 1}
    assert found.tasks == {("write", "submitted"): 2, ("verify", "submitted"): 4, ("verify", "returned"): 1}
    assert found.by_day == {date(2026, 5, 1): 5, date(2026, 5, 2): 1}
    assert found.median_seconds == {"write": 400.0, "verify": 60.0}
    assert found.kept_ndtw == pytest.approx(0.6)
    assert (found.success, found.gold_success) == (0.5, 1.0)
    assert found.agreement == Agreement(1.0, 0.5)
    assert found.paid == {"write": 100, "kept": 10, "verify": 40}


def test_workers() -> None:
    ann, bob, cid = figures_of_workers(
        [worker(name) for name in ("ann", "bob", "cid")], TASKS, TEXTS, WALKS, LEDGER, SETTINGS
    )
    assert (ann.texts, ann.pasted, ann.earned, ann.success) == ({"kept": 1, "discarded": 1}, 1, 110, None)
    assert (bob.verifications, bob.uncounted, bob.success, bob.golds, bob.golds_passed) == (2, 1, 1.0, 1, 1)
    assert (bob.agreement, bob.flag_rate, bob.earned) == (Agreement(1.0, 0.5), 0.5, 20)
    assert (cid.success, cid.returned, cid.median_seconds) == (0.0, 1, {"verify": 100.0})


def test_nothing_yet() -> None:
    found = overview_of([], [], [], [], SETTINGS)
    assert (found.texts, found.by_day, found.kept_ndtw, found.success) == ({}, {}, None, None)
    (figures,) = figures_of_workers([worker("ann")], [], [], [], [], SETTINGS)
    assert (figures.success, figures.earned, figures.agreement) == (None, 0, Agreement(None, None))
