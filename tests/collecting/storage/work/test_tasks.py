"""Tasks: given out one at a time, kept while they are used, given back, and taken up again."""

import pytest

from arramon_collecting.storage.people.records import BLOCKED
from arramon_collecting.storage.records import CLOSED, PAUSED, RUNNING
from arramon_collecting.storage.work.records import EXPIRED, OPEN
from arramon_server.errors import Conflict, Forbidden, NotFound, OverQuota
from tests.collecting.collecting import EPISODES, TEXTS, Field


def test_nobody_writes_for_an_episode_that_has_a_text(field: Field) -> None:
    ann, bob = field.worker(), field.worker()
    first = field.claim(ann).episode_id
    assert (first, field.claim(bob).episode_id) == ("e0", "e1")
    assert field.claim(ann).episode_id == "e0"  # the same task, as in another tab


def test_nobody_verifies_an_own_text_or_an_episode_written_for(field: Field) -> None:
    ann, bob = field.worker(), field.worker()
    field.write(ann)
    assert field.store.tasks.claim_verify(field.collection, ann, ()) is None
    task = field.store.tasks.claim_verify(field.collection, bob, ())
    assert task is not None
    field.store.tasks.give_back(task.task_id)
    assert field.store.tasks.claim_verify(field.collection, bob, ()) is None  # handed back: not again
    assert field.claim(bob).episode_id != task.episode_id  # seen: nothing is written for it


def test_at_most_as_many_verifiers_as_needed(field: Field) -> None:
    field.write(field.worker())
    workers = [field.worker() for _ in range(4)]
    tasks = [field.store.tasks.claim_verify(field.collection, worker, ()) for worker in workers]
    assert [task is not None for task in tasks] == [True, True, True, False]


def test_a_task_that_is_not_used_goes_back_and_can_be_taken_up_again(field: Field) -> None:
    ann, bob = field.worker(), field.worker()
    task = field.claim(ann)
    field.clock.advance(minutes=50)
    field.store.drafts.save(task, 0, {"texts": ["Go"]}, size=10)  # activity
    field.clock.advance(minutes=59)
    field.claim(bob)
    assert field.store.tasks.get(task.task_id).state == OPEN
    field.clock.advance(minutes=2)
    assert field.store.tasks.expire(field.collection) == 1
    assert field.store.tasks.get(task.task_id).state == EXPIRED
    assert field.store.tasks.resume(task).state == OPEN
    assert field.store.drafts.get(task.task_id).body == {"texts": ["Go"]}


def test_an_expired_task_that_somebody_else_does_is_gone(field: Field) -> None:
    ann, bob = field.worker(), field.worker()
    task = field.claim(ann)
    field.clock.advance(minutes=61)
    assert field.claim(bob).episode_id == task.episode_id
    with pytest.raises(Conflict, match="given to somebody else"):
        field.store.tasks.resume(task)
    with pytest.raises(Conflict, match="the task is expired already"):
        field.store.submissions.submit_text(field.collection, task, "late", TEXTS)


def test_a_late_submission_counts_while_the_episode_is_free(field: Field) -> None:
    ann = field.worker()
    task = field.claim(ann)
    field.clock.advance(minutes=61)
    field.store.tasks.expire(field.collection)
    done = field.store.submissions.submit_text(field.collection, task, "late", TEXTS)
    assert (done.task.state, field.owed(ann)) == ("submitted", 100)


def test_active_time_leaves_out_long_pauses(field: Field) -> None:
    task = field.claim(field.worker())
    for pause in (10, 20, 600):
        field.clock.advance(seconds=pause)
        task = field.store.tasks.touch(task.task_id, {"index": pause})
    assert (task.active_seconds, task.position) == (90.0, {"index": 600})


@pytest.mark.parametrize("state", [PAUSED, CLOSED])
def test_a_paused_collection_gives_out_nothing_but_takes_what_is_open(field: Field, state: str) -> None:
    ann = field.worker()
    task = field.claim(ann)
    field.store.collections.set_state("col", state)
    assert field.claim(ann).task_id == task.task_id
    assert field.store.submissions.submit_text(field.collection, task, "s", TEXTS).text is not None
    with pytest.raises(Conflict, match=f"the collection is {state}"):
        field.claim(ann)
    field.store.collections.set_state("col", RUNNING)
    assert field.claim(ann).state == OPEN


def test_blocked_workers_get_nothing_and_their_task_goes_back(field: Field) -> None:
    ann = field.worker()
    task = field.claim(ann)
    field.store.workers.set_state(ann.worker_id, BLOCKED)
    assert field.store.tasks.get(task.task_id).state == "returned"
    with pytest.raises(Forbidden, match="the worker is blocked"):
        field.claim(field.store.workers.get(ann.worker_id))


def test_a_worker_may_do_only_so_many(field: Field) -> None:
    limited = field.store.collections.create(
        "few", "write", "en", "sample", field.collection.settings.model_copy(update={"max_tasks": 1})
    )
    invited, _ = field.store.workers.invite(limited)
    field.store.workers.consent(invited, limited, keep_texts=True)
    ann = field.store.workers.get(invited.worker_id)
    task = field.store.tasks.claim_write(limited, ann, EPISODES)
    assert task is not None
    field.store.submissions.submit_text(limited, task, "s", TEXTS)
    with pytest.raises(OverQuota, match="you have done 1 tasks of this kind"):
        field.store.tasks.claim_write(limited, ann, EPISODES)


def test_other_workers_tasks_do_not_exist(field: Field) -> None:
    task = field.claim(field.worker())
    with pytest.raises(NotFound):
        field.store.tasks.of_worker(field.worker(), task.task_id)


def test_golds_come_by_chance_and_look_like_any_task(field: Field) -> None:
    chosen = field.collection.settings.model_copy(update={"gold_share": 0.5})
    collection = field.store.collections.create("golds", "write", "en", "sample", chosen)
    workers = []
    for _ in range(2):
        invited, _ = field.store.workers.invite(collection)
        field.store.workers.consent(invited, collection, keep_texts=True)
        workers.append(field.store.workers.get(invited.worker_id))
    author, verifier = workers
    task = field.store.tasks.claim_write(collection, author, EPISODES)
    assert task is not None
    field.store.submissions.submit_text(collection, task, "s", TEXTS)
    field.draws = [0.0, 0.5]
    gold = field.store.tasks.claim_verify(collection, verifier, ["g0", "g1"])
    assert gold is not None
    assert (gold.is_gold, gold.text_id, gold.episode_id) == (True, None, "g1")
    field.store.tasks.give_back(gold.task_id)
    field.draws = [0.99]
    other = field.store.tasks.claim_verify(collection, verifier, ["g0", "g1"])
    assert other is not None
    assert not other.is_gold


def test_the_run_of_the_first_tab_stays(field: Field) -> None:
    field.write(field.worker())
    task = field.store.tasks.claim_verify(field.collection, field.worker(), ())
    assert task is not None
    set_run = field.store.tasks.set_run
    assert (set_run(task.task_id, None, "1" * 32), set_run(task.task_id, None, "2" * 32)) == ("1" * 32, "1" * 32)
    assert set_run(task.task_id, "1" * 32, "3" * 32) == "3" * 32
