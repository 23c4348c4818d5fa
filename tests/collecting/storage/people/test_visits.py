"""Visits from crowd platforms: the completion code comes only for what is committed, and the list to reconcile."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_collecting.storage.people.records import Worker
from arramon_server.errors import BadInput, NotFound
from arramon_server.runs.storage.database import Database
from tests.collecting.collecting import Field

STUDY = {"code": "CODE-1", "tasks": 2, "stages": ["write"]}


@pytest.fixture
def field(database_url: str) -> Iterator[Field]:
    made = Field(Database(database_url), platform={"key": "secret", "studies": {"s": STUDY}})
    with closing(made.database):
        yield made


def come(field: Field, external_id: str, session: str) -> Worker:
    worker = field.store.workers.join(field.collection, external_id, ("write",))
    field.store.visits.begin(worker.worker_id, "s", session)
    if worker.consented_at is None:
        field.store.workers.consent(worker, field.collection, keep_texts=True)
    return field.store.workers.get(worker.worker_id)


def code(field: Field, worker: Worker) -> str | None:
    return field.store.visits.completion_code(field.collection, worker)


def test_the_code_comes_once_the_studys_tasks_are_submitted(field: Field) -> None:
    worker = come(field, "p1", "1")
    assert code(field, worker) is None
    field.write(worker)
    field.claim(worker)
    assert code(field, worker) is None  # the second one is open
    field.write(worker)
    assert code(field, worker) == "CODE-1"


def test_a_second_visit_has_a_code_of_its_own(field: Field) -> None:
    worker = come(field, "p1", "1")
    for _ in range(2):
        field.write(worker)
    assert code(field, worker) == "CODE-1"
    field.clock.advance(days=1)
    again = come(field, "p1", "2")
    assert again.worker_id == worker.worker_id
    assert code(field, again) is None


def test_the_same_session_is_one_visit(field: Field) -> None:
    first, second = come(field, "p1", "1"), come(field, "p1", "1")
    assert first == second
    assert len(field.store.visits.reconcile("col")) == 1


def test_the_list_says_who_left_in_between(field: Field) -> None:
    done, left, returned = come(field, "done", "1"), come(field, "left", "2"), come(field, "returned", "3")
    for worker, number in ((done, 2), (left, 1)):
        for _ in range(number):
            field.write(worker)
    field.claim(returned)
    code(field, done)
    gone = field.store.visits.mark_returned("col", "returned")
    assert gone.worker_id == returned.worker_id
    found = [
        (one.external_id, one.submitted, one.amount_minor, one.state) for one in field.store.visits.reconcile("col")
    ]
    assert sorted(found) == [("done", 2, 200, "complete"), ("left", 1, 100, "left"), ("returned", 0, 0, "returned")]
    assert code(field, returned) is None
    with pytest.raises(NotFound, match="no worker with the platform's id 'nobody'"):
        field.store.visits.mark_returned("col", "nobody")


@pytest.mark.parametrize("external_id", ["", "x" * 201, "a\nb", "a\u202eb"])
def test_malformed_ids_are_refused(field: Field, external_id: str) -> None:
    with pytest.raises(BadInput, match="the platform's id is"):
        field.store.workers.join(field.collection, external_id, ("write",))
