"""Sends queued mails by SMTP, in a thread of its own."""

import logging
import smtplib
import ssl
import threading
from email.message import EmailMessage
from email.utils import format_datetime

from arramon_collecting.settings import SmtpSettings, smtp_password
from arramon_collecting.storage.records import Mail
from arramon_collecting.storage.store import Store
from arramon_server.addresses import is_loopback
from arramon_server.errors import ArraMonError, BadInput, StorageError

SECONDS, INTERVAL_SECONDS, CLOSE_SECONDS = 20.0, 5.0, 3.0
"""Time limit of each answer of the SMTP server, time between two looks at the queue, and time that the end waits."""

_log = logging.getLogger(__name__)


class MailSender:
    """Sends the mails of all collections until it is closed. Mails under way are sent again after a restart.

    Args:
        store: storage of the collections.
        interval_seconds: time between two looks at the queue.
    """

    def __init__(self, store: Store, interval_seconds: float = INTERVAL_SECONDS) -> None:
        self._store = store
        self._interval_seconds = interval_seconds
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="collecting-mail", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread. A mail under way is finished if that is quick, or tried again after the restart."""
        self._stopped.set()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_SECONDS)

    def _run(self) -> None:
        while not self._stopped.is_set():
            try:
                while not self._stopped.is_set() and self.send_next():
                    pass
            except StorageError as error:
                _log.info("the mail queue cannot be read: %s", error)  # the engine warns of outages
            self._stopped.wait(self._interval_seconds)

    def send_next(self) -> bool:
        """Try to send the next mail that is due; return False if none is."""
        if (mail := self._store.mail.take()) is None:
            return False
        try:
            smtp = self._store.collections.get(mail.collection).settings.smtp
            send(smtp, mail)
        except smtplib.SMTPRecipientsRefused as error:
            refusals = list(error.recipients.values())
            is_final = all(code >= 500 for code, _ in refusals)
            self._note_failure(mail, f"the address was refused: {refusals}", for_good=is_final)
        except (OSError, smtplib.SMTPException, ArraMonError) as error:
            self._note_failure(mail, str(error) or type(error).__name__)
        else:
            self._store.mail.mark_sent(mail)
        return True

    def _note_failure(self, mail: Mail, problem: str, *, for_good: bool = False) -> None:
        _log.warning("mail %s could not be sent: %s", mail.mail_id, problem)
        self._store.mail.mark_failed(mail, problem, for_good=for_good)


def send(smtp: SmtpSettings, mail: Mail) -> None:
    """Send a mail.

    Raises:
        OSError, smtplib.SMTPException: if the server is away or refuses it.
        BadInput: if the settings do not allow a secure connection.
        BadFile: if the file with the password cannot be used.
    """
    if smtp.security == "none" and not is_loopback(f"{smtp.host}:{smtp.port}"):
        raise BadInput(f"smtp.security is 'none', but {smtp.host} is another machine; expected 'starttls' or 'tls'")
    context = ssl.create_default_context()
    if smtp.security == "tls":
        client: smtplib.SMTP = smtplib.SMTP_SSL(smtp.host, smtp.port, timeout=SECONDS, context=context)
    else:
        client = smtplib.SMTP(smtp.host, smtp.port, timeout=SECONDS)
    with client:
        if smtp.security == "starttls":
            client.starttls(context=context)
        if smtp.user:
            client.login(smtp.user, smtp_password(smtp))
        client.send_message(message_of(smtp, mail))


def message_of(smtp: SmtpSettings, mail: Mail) -> EmailMessage:
    """Return a mail as a message. Its id is always the same, so that a mail sent twice can be recognised."""
    sender = smtp.sender or smtp.user
    message = EmailMessage()
    message["From"], message["To"], message["Subject"] = sender, mail.recipient, mail.subject
    message["Date"] = format_datetime(mail.created_at)
    message["Message-ID"] = f"<{mail.mail_id}@{sender.rpartition('@')[2] or 'localhost'}>"
    message["Auto-Submitted"] = "auto-generated"
    message.set_content(mail.body)
    return message
