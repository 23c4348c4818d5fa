"""Reviews of texts by hosts: accept, mend, send back, reject; each in one transaction with pay and mail."""

from collections.abc import Sequence

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.rules.keeping import DISCARD, decide
from arramon_collecting.storage.mail_queue import Letter, enqueue
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection, record_of
from arramon_collecting.storage.texts.records import (
    DISCARDED,
    IN_REVIEW,
    KEPT,
    REJECTED,
    SENT_BACK,
    VERIFYING,
    Instructions,
    Text,
)
from arramon_collecting.storage.transactions import Clock, lock, utc_now
from arramon_collecting.storage.work.submissions import accept, outcomes_of, pay_if_kept, replace_text
from arramon_server.errors import BadInput, Conflict, NotFound, quoted
from arramon_server.runs.storage.collection_tables import texts, workers
from arramon_server.runs.storage.database import Database

MAX_REASON = 2000
"""Maximum number of characters of a reason."""


class Reviews:
    """Reviews in all collections. Each names the version of the text that the host saw.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def accept(
        self, collection: Collection, text_id: str, version: int, host: Worker, letter: Letter | None = None
    ) -> Text:
        """Accept a text in review, which pays its author. It is kept if it was verified, else goes to the verifiers;
        an imported one is kept.

        Args:
            collection: the text's collection.
            text_id: the text.
            version: the version that the host saw.
            host: who reviews.
            letter: mail to the author; None for none.

        Raises:
            NotFound: if there is no such text.
            Conflict: if it is not in review, or has a newer version.
        """
        with self._database.write() as connection:
            text, now = _locked(connection, collection, text_id, version, (IN_REVIEW,)), self._clock()
            accept(connection, collection, text, now)
            decision = decide(outcomes_of(connection, text_id), collection.settings)
            waits = VERIFYING if decision is None else DISCARDED if decision == DISCARD else KEPT
            state = KEPT if text.worker_id is None else waits
            pay_if_kept(connection, collection, text, state, now)
            return self._reviewed(connection, collection, text, host, state, "", letter)

    def send_back(
        self,
        collection: Collection,
        text_id: str,
        version: int,
        host: Worker,
        reason: str,
        letter: Letter | None = None,
    ) -> Text:
        """Send a text back to its author, who may mend it.

        Raises:
            BadInput: if the reason is empty or too long, or the text was imported and has no author.
            NotFound, Conflict: as for `accept`.
        """
        with self._database.write() as connection:
            text = _locked(connection, collection, text_id, version, (IN_REVIEW, VERIFYING))
            if text.worker_id is None:
                raise BadInput("the text was imported and has no author; mend or reject it")
            return self._reviewed(connection, collection, text, host, SENT_BACK, _checked(reason), letter)

    def reject(
        self,
        collection: Collection,
        text_id: str,
        version: int,
        host: Worker,
        reason: str,
        letter: Letter | None = None,
    ) -> Text:
        """Reject a text, which is not used. What was paid for it stays paid.

        Raises:
            BadInput: if the reason is empty or too long.
            NotFound, Conflict: as for `accept`.
        """
        with self._database.write() as connection:
            text = _locked(connection, collection, text_id, version, (IN_REVIEW, VERIFYING, SENT_BACK))
            return self._reviewed(connection, collection, text, host, REJECTED, _checked(reason), letter)

    def mend(
        self, collection: Collection, text_id: str, version: int, host: Worker, instructions: Instructions
    ) -> Text:
        """Replace the instructions of a text in review by those of the host; it stays in review.

        Raises:
            NotFound, Conflict: as for `accept`.
        """
        with self._database.write() as connection:
            text, now = _locked(connection, collection, text_id, version, (IN_REVIEW,)), self._clock()
            values = {"instructions": [list(pair) for pair in instructions]}
            replace_text(connection, text, values, now, by=host.worker_id)
            return self._reviewed(connection, collection, text, host, IN_REVIEW, "", None)

    def _reviewed(
        self,
        connection: Connection,
        collection: Collection,
        text: Text,
        host: Worker,
        state: str,
        reason: str,
        letter: Letter | None,
    ) -> Text:
        now = self._clock()
        values = {"state": state, "reason": reason, "reviewed_at": now, "reviewed_by": host.worker_id}
        connection.execute(texts.update().where(texts.c.text_id == text.text_id).values(**values))
        if letter is not None and text.worker_id is not None:
            row = connection.execute(sa.select(workers).where(workers.c.worker_id == text.worker_id)).one()
            enqueue(connection, collection, record_of(Worker, row), letter, now)
        return record_of(Text, connection.execute(sa.select(texts).where(texts.c.text_id == text.text_id)).one())


def _locked(connection: Connection, collection: Collection, text_id: str, version: int, among: Sequence[str]) -> Text:
    lock(connection, collection.name)
    query = sa.select(texts).where(texts.c.text_id == text_id, texts.c.collection == collection.name)
    if (row := connection.execute(query).first()) is None:
        raise NotFound(f"there is no text {quoted(text_id)}")
    found = record_of(Text, row)
    if found.version != version:
        raise Conflict(f"the text has version {found.version} now, but version {version} was reviewed")
    if found.state not in among:
        raise Conflict(f"the text is {found.state}, expected {' or '.join(among)}")
    return found


def _checked(reason: str) -> str:
    found = reason.strip()
    if not found or len(found) > MAX_REASON:
        raise BadInput(f"the reason has {len(found)} characters, expected 1 to {MAX_REASON}")
    return found
