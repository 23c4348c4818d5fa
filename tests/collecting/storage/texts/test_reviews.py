"""Reviews: of the version that was seen, with pay and mail in one transaction."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_collecting.storage.mail_queue import Letter
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.texts.records import IN_REVIEW, KEPT, REJECTED, SENT_BACK, VERIFYING, Text
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.storage.database import Database
from tests.collecting.collecting import TEXTS, Field

SOFT = [{"turn": 1, "phase": "navigation", "check": "counts", "severity": "suspicious", "message": "5 feet"}]
LETTER = Letter("About your text", "It was looked at.")


@pytest.fixture
def field(database_url: str) -> Iterator[Field]:
    made = Field(Database(database_url), smtp={"host": "localhost"})
    with closing(made.database):
        yield made


def doubtful(field: Field, author: Worker) -> Text:
    text = field.write(author, failures=SOFT).text
    assert text is not None
    assert text.state == IN_REVIEW
    return text


def test_a_host_decides_once_and_about_what_was_seen(field: Field) -> None:
    author, host = field.worker(), field.worker(role="host")
    text = doubtful(field, author)
    reviews = field.store.reviews
    with pytest.raises(Conflict, match="has version 1 now, but version 2 was reviewed"):
        reviews.accept(field.collection, text.text_id, 2, host)
    assert reviews.accept(field.collection, text.text_id, 1, host).state == VERIFYING
    with pytest.raises(Conflict, match="the text is verifying, expected in_review"):
        reviews.accept(field.collection, text.text_id, 1, host)
    assert field.owed(author) == 100
    with pytest.raises(NotFound):
        reviews.accept(field.collection, "0" * 32, 1, host)


def test_a_rejected_text_is_not_paid_and_the_episode_is_free_again(field: Field) -> None:
    author, host = field.worker(), field.worker(role="host")
    text = doubtful(field, author)
    for reason in ("", " ", "x" * 2001):
        with pytest.raises(BadInput, match="the reason has"):
            field.store.reviews.reject(field.collection, text.text_id, 1, host, reason)
    found = field.store.reviews.reject(field.collection, text.text_id, 1, host, "not this language")
    assert (found.state, found.reason, found.reviewed_by) == (REJECTED, "not this language", host.worker_id)
    assert field.owed(author) == 0
    assert field.claim(field.worker()).episode_id == text.episode_id
    assert field.claim(author).episode_id != text.episode_id


def test_a_flagged_text_that_is_accepted_is_kept_and_paid_once(field: Field) -> None:
    author, host = field.worker(), field.worker(role="host")
    field.write(author)
    for _ in range(3):
        field.verify(field.worker(), flags=("unclear",))
    (text,) = field.store.texts.all("col", IN_REVIEW)
    assert field.owed(author) == 100
    assert field.store.reviews.accept(field.collection, text.text_id, 1, host).state == KEPT
    assert field.owed(author) == 110


def test_verifications_of_an_earlier_version_do_not_count(field: Field) -> None:
    author, host = field.worker(), field.worker(role="host")
    text = field.write(author).text
    assert text is not None
    field.verify(field.worker())
    field.store.reviews.send_back(field.collection, text.text_id, 1, host, "which bank?")
    task = field.store.tasks.claim_mend(field.collection, author, text.text_id)
    better = (("Turn left at the tall red bank.", TEXTS[0][1]), TEXTS[1])
    mended = field.store.submissions.submit_text(field.collection, task, "m", better).text
    assert mended is not None
    assert (mended.version, mended.state, mended.instructions_of(1), mended.instructions_of(2)) == (
        2, IN_REVIEW, TEXTS, better,
    )  # fmt: skip
    assert [one.counts for one in field.store.verifications.of_text(text.text_id)] == [False]
    assert field.store.reviews.accept(field.collection, text.text_id, 2, host).state == VERIFYING
    assert field.owed(author) == 100  # once for both versions


def test_mail_is_queued_with_the_decision_or_not_at_all(field: Field) -> None:
    author, host = field.worker(email="ann@example.org"), field.worker(role="host")
    text = doubtful(field, author)
    with pytest.raises(Conflict):
        field.store.reviews.accept(field.collection, text.text_id, 9, host, LETTER)
    assert field.store.mail.all("col") == []
    field.store.reviews.send_back(field.collection, text.text_id, 1, host, "why?", LETTER)
    (mail,) = field.store.mail.all("col")
    assert (mail.recipient, mail.subject, mail.state) == ("ann@example.org", LETTER.subject, "queued")
    silent = doubtful(field, field.worker())
    field.store.reviews.accept(field.collection, silent.text_id, 1, host, LETTER)
    assert len(field.store.mail.all("col")) == 1


def test_imported_texts_are_accepted_mended_and_rejected_without_pay(field: Field) -> None:
    host = field.worker(role="host")
    generated = [(f"e{number}", TEXTS) for number in range(3)]
    settings = field.collection.settings
    review = field.store.collections.create("review", "review", "en", "sample", settings, generated)
    first, second, third = field.store.texts.all("review", IN_REVIEW)
    reviews = field.store.reviews
    assert reviews.accept(review, first.text_id, 1, host).state == KEPT
    better = (("Turn left at the bank.", TEXTS[0][1]), TEXTS[1])
    mended = reviews.mend(review, second.text_id, 1, host, better)
    assert (mended.state, mended.version, mended.instructions) == (IN_REVIEW, 2, better)
    assert reviews.accept(review, second.text_id, 2, host).state == KEPT
    with pytest.raises(BadInput, match="has no author; mend or reject it"):
        reviews.send_back(review, third.text_id, 1, host, "no")
    assert reviews.reject(review, third.text_id, 1, host, "wrong side").state == REJECTED
    assert field.store.ledger.entries("review") == []
    assert SENT_BACK not in field.store.texts.counts("review")
