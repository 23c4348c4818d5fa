"""Submissions: decided, paid and counted once, each in one transaction."""

import pytest

from arramon_collecting.storage.texts.records import DISCARDED, IN_REVIEW, KEPT, VERIFYING
from arramon_server.errors import BadInput, Conflict
from tests.collecting.collecting import BADLY, TEXTS, WELL, Field

SOFT = {"turn": 1, "phase": "navigation", "check": "counts", "severity": "suspicious", "message": "5 feet"}


def test_a_text_that_passes_goes_to_verifiers_and_is_paid(field: Field) -> None:
    author = field.worker()
    done = field.write(author)
    assert done.text is not None
    assert (done.text.state, done.text.instructions, done.text.worker_id) == (VERIFYING, TEXTS, author.worker_id)
    assert [(one.kind, one.amount_minor) for one in done.paid] == [("write", 100)]
    assert field.owed(author) == 100


def test_a_double_submission_changes_nothing(field: Field) -> None:
    author = field.worker()
    task = field.claim(author)
    submit = field.store.submissions.submit_text
    first, second = (submit(field.collection, task, "once", TEXTS) for _ in range(2))
    assert (first.repeated, second.repeated) == (False, True)
    assert second.text == first.text
    with pytest.raises(Conflict, match="the task is submitted already"):
        submit(field.collection, task, "another tab", TEXTS)
    assert field.owed(author) == 100
    assert len(field.store.texts.all("col")) == 1


def test_a_doubtful_text_is_reviewed_and_paid_when_it_is_accepted(field: Field) -> None:
    author, host = field.worker(), field.worker(role="host")
    done = field.write(author, failures=[SOFT])
    assert done.text is not None
    assert (done.text.state, done.paid, field.owed(author)) == (IN_REVIEW, (), 0)
    accepted = field.store.reviews.accept(field.collection, done.text.text_id, 1, host)
    assert (accepted.state, field.owed(author)) == (VERIFYING, 100)


def test_a_text_that_fails_a_blocking_check_is_refused(field: Field) -> None:
    with pytest.raises(BadInput, match="5 feet"):
        field.write(field.worker(), failures=[{**SOFT, "severity": "blocked"}])
    assert field.store.texts.all("col") == []


@pytest.mark.parametrize(
    ("scores", "flags", "state", "owed"),
    [
        ((WELL, BADLY, BADLY), ((), (), ()), KEPT, 110),
        ((BADLY, BADLY, BADLY), ((), (), ()), DISCARDED, 100),
        ((WELL, WELL, WELL), (("unclear",), ("wrong",), ()), IN_REVIEW, 100),
        ((BADLY, BADLY, BADLY), (("unclear",), ("wrong",), ()), DISCARDED, 100),
    ],
)
def test_the_papers_rule_decides_after_three_verifications(
    field: Field, scores: tuple[tuple[float, float], ...], flags: tuple[tuple[str, ...], ...], state: str, owed: int
) -> None:
    author = field.worker()
    text = field.write(author).text
    assert text is not None
    verifiers = [field.worker() for _ in range(3)]
    for verifier, ndtw, ticked in zip(verifiers, scores, flags, strict=True):
        assert field.store.texts.get(text.text_id).state == VERIFYING
        field.verify(verifier, ndtw, ticked)
    assert field.store.texts.get(text.text_id).state == state
    assert (field.owed(author), [field.owed(one) for one in verifiers]) == (owed, [20, 20, 20])


def test_a_verification_that_was_too_quick_neither_counts_nor_is_paid(field: Field) -> None:
    text = field.write(field.worker()).text
    assert text is not None
    hasty = field.worker()
    field.verify(hasty, seconds=3.0)
    for _ in range(2):
        field.verify(field.worker())
    assert (field.store.texts.get(text.text_id).state, field.owed(hasty)) == (VERIFYING, 0)
    field.verify(field.worker())
    assert field.store.texts.get(text.text_id).state == KEPT


def test_milestones_are_paid_once_each(field: Field) -> None:
    """The paper's: 0.10 after 5 texts, 0.90 after 20."""
    author = field.worker()
    owed = [field.write(author).paid for _ in range(6)]
    assert [[one.kind for one in paid] for paid in owed[3:]] == [["write"], ["write", "milestone-5"], ["write"]]
    assert field.owed(author) == 610
