"""Drafts: a newer one is never overwritten by an older one, and none outlives its task."""

import pytest

from arramon_collecting.storage.work.drafts import MAX_DRAFT_BYTES, OlderDraft
from arramon_server.errors import BadInput, Conflict
from tests.collecting.collecting import TEXTS, Field


def test_a_draft_survives_and_grows(field: Field) -> None:
    task = field.claim(field.worker())
    assert field.store.drafts.get(task.task_id).revision == 0
    for revision, text in enumerate(("बाएँ", "बाएँ मुड़ें")):
        assert field.store.drafts.save(task, revision, {"text": text}, size=9).revision == revision + 1
    found = field.store.drafts.get(task.task_id)
    assert (found.revision, found.body, found.saved_at) == (2, {"text": "बाएँ मुड़ें"}, field.clock.now)


def test_an_older_draft_is_refused_with_the_newer_one(field: Field) -> None:
    task = field.claim(field.worker())
    save = field.store.drafts.save
    save(task, 0, {"text": "first tab"}, size=9)
    with pytest.raises(OlderDraft, match="based on revision 0, but 1 was saved meanwhile") as refused:
        save(task, 0, {"text": "second tab"}, size=9)
    assert refused.value.newer.body == {"text": "first tab"}
    assert save(task, 0, {"text": "first tab"}, size=9).revision == 1  # the answer was lost: saved once
    assert save(task, 1, {"text": "second tab"}, size=9).revision == 2


def test_large_drafts_and_those_of_ended_tasks_are_refused(field: Field) -> None:
    task = field.claim(field.worker())
    with pytest.raises(BadInput, match="the draft has 262145 bytes"):
        field.store.drafts.save(task, 0, {}, size=MAX_DRAFT_BYTES + 1)
    field.store.drafts.save(task, 0, {"text": "x"}, size=9)
    field.store.submissions.submit_text(field.collection, task, "s", TEXTS)
    with pytest.raises(Conflict, match="the task is submitted"):
        field.store.drafts.save(task, 1, {"text": "y"}, size=9)
    assert field.store.drafts.get(task.task_id).revision == 0
