"""Mails to workers about their texts, in the language of the pages that they read."""

from arramon_collecting.storage.mail_queue import Letter
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.web.texts import texts_of
from arramon_server.errors import NotFound
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts

DECISIONS = ("accepted", "sent_back", "rejected")
"""What a host may decide about a text."""


def letter_for(
    collection: Collection, worker: Worker, decision: str, *, reason: str = "", site: str = ""
) -> Letter | None:
    """Return the mail that tells a worker what was decided; None if the worker or the collection wants no mail.

    Args:
        collection: the collection.
        worker: the author of the text.
        decision: one of DECISIONS.
        reason: the host's reason; empty for an accepted text.
        site: the site's address, such as "https://example.org".
    """
    assert decision in DECISIONS
    if not (collection.settings.smtp.host and worker.email):
        return None
    t = _texts(worker)
    address = f"{site}/{t.language}/collect/{collection.name}/"
    subject = t(f"collect_mail.{decision}_subject")
    return Letter(
        subject, t(f"collect_mail.{decision}_body", collection=collection.name, reason=reason, address=address)
    )


def _texts(worker: Worker) -> PageTexts:
    try:
        return texts_of(worker.page_language or DEFAULT_LANGUAGE)
    except NotFound:
        return texts_of(DEFAULT_LANGUAGE)
