"""Mails by a real SMTP server on this machine: sent once, kept while the server is away, given up when refused."""

from asyncio.base_events import Server
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import timedelta
from email import message_from_bytes, policy
from email.message import EmailMessage
from pathlib import Path

import pytest
from aiosmtpd.controller import Controller
from aiosmtpd.smtp import SMTP, Envelope, Session

from arramon_collecting.mail_sender import MailSender, message_of, send
from arramon_collecting.settings import SmtpSettings
from arramon_collecting.storage.mail_queue import FIRST_PAUSE, SENDING_TIME, MailQueue, enqueue
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import FAILED, QUEUED, SENDING, SENT, Mail
from arramon_collecting.web.review.letters import letter_for
from arramon_server.errors import BadFile, BadInput
from arramon_server.runs.storage.database import Database
from tests.collecting.collecting import Field


class Inbox:
    """Handler of the SMTP server: keeps messages, and refuses addresses at `gone.example`."""

    def __init__(self) -> None:
        self.messages: list[EmailMessage] = []

    async def handle_RCPT(  # noqa: N802 - the server's name for it
        self, _: SMTP, __: Session, envelope: Envelope, address: str, ___: list[str]
    ) -> str:
        if address.endswith("@gone.example"):
            return "550 no such person"
        envelope.rcpt_tos.append(address)
        return "250 OK"

    async def handle_DATA(self, _: SMTP, __: Session, envelope: Envelope) -> str:  # noqa: N802
        assert isinstance(envelope.content, bytes)
        self.messages.append(message_from_bytes(envelope.content, EmailMessage, policy=policy.default))
        return "250 OK"


class LocalServer(Controller):
    """An SMTP server on a free port, which is known once it listens."""

    def _trigger_server(self) -> None:
        assert isinstance(self.server, Server)
        self.port = self.server.sockets[0].getsockname()[1]
        super()._trigger_server()  # type: ignore[no-untyped-call]


@contextmanager
def serving(port: int = 0) -> Iterator[Controller]:
    """Run an SMTP server, on a free port."""
    controller = LocalServer(Inbox(), hostname="127.0.0.1", port=port)
    controller.start()
    try:
        yield controller
    finally:
        controller.stop()


@pytest.fixture
def smtp() -> Iterator[Controller]:
    with serving() as controller:
        yield controller


def field(folder: Path, port: int, **further: object) -> Field:
    smtp = {"host": "127.0.0.1", "port": port, "security": "none", "sender": "host@example.org", **further}
    return Field(Database(f"sqlite:///{folder / 'journal.db'}"), smtp=smtp)


def queued(made: Field, email: str = "ann@example.org", page_language: str = "hi") -> Mail:
    """Queue a mail as a review does."""
    worker: Worker = made.worker()
    made.store.workers.set_contact(worker.worker_id, email=email, page_language=page_language)
    worker = made.store.workers.get(worker.worker_id)
    letter = letter_for(made.collection, worker, "sent_back", reason="कौन-सा बैंक?", site="https://a.org")
    assert letter is not None
    with made.database.write() as connection:
        assert enqueue(connection, made.collection, worker, letter, made.clock.now)
    return made.store.mail.all("col")[-1]


def state(made: Field) -> tuple[str, int]:
    mail = made.store.mail.all("col")[-1]
    return mail.state, mail.attempts


def test_a_mail_is_sent_once_in_the_workers_language(tmp_path: Path, smtp: Controller) -> None:
    with closing((made := field(tmp_path, smtp.port)).database):
        queued(made)
        sender = MailSender(made.store)
        assert (sender.send_next(), sender.send_next()) == (True, False)
        (message,) = smtp.handler.messages
        assert (message["To"], message["From"]) == ("ann@example.org", "host@example.org")
        assert message["Subject"] == "कृपया अपने निर्देश फिर देखें"
        body = message.get_content()
        assert "कौन-सा बैंक?" in body
        assert "https://a.org/hi/collect/col/" in body
        (mail,) = made.store.mail.all("col")
        assert (mail.state, mail.recipient, mail.body) == (SENT, "", "")


def test_a_mail_waits_while_the_server_is_away(tmp_path: Path) -> None:
    with serving() as gone:
        port = gone.port
    with closing((made := field(tmp_path, port)).database):
        queued(made)
        sender = MailSender(made.store)
        assert sender.send_next()
        assert state(made) == (QUEUED, 1)
        assert "refused" in made.store.mail.all("col")[0].problem.lower()
        assert not sender.send_next()  # not before the pause is over
        made.clock.now += FIRST_PAUSE
        with serving(port) as again:
            assert MailSender(made.store).send_next()  # as after a restart
        assert state(made) == (SENT, 2)
        assert len(again.handler.messages) == 1


def test_pauses_grow_and_a_mail_fails_in_the_end(tmp_path: Path) -> None:
    with closing((made := field(tmp_path, 1)).database):
        queued(made)
        pauses = []
        while made.store.mail.all("col")[0].state == QUEUED:
            mail = made.store.mail.take()
            assert mail is not None
            made.store.mail.mark_failed(mail, "away")
            pauses.append(made.store.mail.all("col")[0].next_at - made.clock.now)
            made.clock.now += pauses[-1]
        assert pauses[:3] == [timedelta(minutes=1), timedelta(minutes=2), timedelta(minutes=4)]
        assert (len(pauses), pauses[-1], state(made)[0]) == (12, timedelta(hours=6), FAILED)


def test_a_mail_of_a_killed_process_is_taken_over(tmp_path: Path) -> None:
    with closing((made := field(tmp_path, 1)).database):
        queued(made)
        assert made.store.mail.take() is not None
        assert state(made) == (SENDING, 1)
        other = MailQueue(made.database, made.clock)
        assert other.take() is None
        made.clock.now += SENDING_TIME
        taken = other.take()
        assert taken is not None
        assert taken.attempts == 2


def test_a_refused_address_is_given_up(tmp_path: Path, smtp: Controller) -> None:
    with closing((made := field(tmp_path, smtp.port)).database):
        queued(made, email="bob@gone.example")
        assert MailSender(made.store).send_next()
        assert state(made) == (FAILED, 1)
        assert "no such person" in made.store.mail.all("col")[0].problem


def test_no_password_or_address_leaves_this_machine_in_the_clear(tmp_path: Path) -> None:
    with closing((made := field(tmp_path, 25, host="mail.example.org")).database):
        mail = queued(made)
        with pytest.raises(BadInput, match=r"smtp.security is 'none', but mail.example.org is another machine"):
            send(made.collection.settings.smtp, mail)


def test_the_password_is_in_a_file_of_its_own(tmp_path: Path, smtp: Controller) -> None:
    path = tmp_path / "password"
    path.write_text("secret\n")
    path.chmod(0o644)
    with closing((made := field(tmp_path, smtp.port, user="u", password_file=str(path))).database):
        mail = queued(made)
        with pytest.raises(BadFile, match="others may read it"):
            send(made.collection.settings.smtp, mail)


@pytest.mark.parametrize("email", ["a", "a@b", "a b@c.org", "a@c.org\nBcc: x@y.org", "a@c.org, b@c.org", "<a@c.org>"])
def test_addresses_that_would_be_headers_are_refused(tmp_path: Path, email: str) -> None:
    with closing((made := field(tmp_path, 1)).database), pytest.raises(BadInput, match="the mail address is"):
        made.worker(email=email)


def test_a_message_has_the_same_id_each_time(tmp_path: Path) -> None:
    with closing((made := field(tmp_path, 1)).database):
        mail = queued(made)
    smtp = SmtpSettings(host="h", sender="host@example.org")
    first, second = (message_of(smtp, mail)["Message-ID"] for _ in range(2))
    assert first == second == f"<{mail.mail_id}@example.org>"
