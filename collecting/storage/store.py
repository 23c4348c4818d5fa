"""The storage of collections in one place."""

from collections.abc import Callable

from arramon_collecting.storage.collections import Collections
from arramon_collecting.storage.mail_queue import MailQueue
from arramon_collecting.storage.payments.ledger import Ledger
from arramon_collecting.storage.people.removal import Removal
from arramon_collecting.storage.people.sign_ins import SignIns
from arramon_collecting.storage.people.visits import Visits
from arramon_collecting.storage.people.workers import Workers
from arramon_collecting.storage.texts.reviews import Reviews
from arramon_collecting.storage.texts.texts import Texts
from arramon_collecting.storage.texts.verifications import Verifications
from arramon_collecting.storage.transactions import Clock, random_number, utc_now
from arramon_collecting.storage.work.drafts import Drafts
from arramon_collecting.storage.work.submissions import Submissions
from arramon_collecting.storage.work.tasks import Tasks
from arramon_server.runs.storage.database import Database


class Store:
    """All groups of tables of collections on one database; thread-safe, as the database is.

    Args:
        database: the journal's database.
        clock: returns the present time.
        draw: returns random numbers in [0, 1), by which golds are chosen.
    """

    def __init__(self, database: Database, clock: Clock = utc_now, draw: Callable[[], float] = random_number) -> None:
        self.clock = clock
        self.collections = Collections(database, clock)
        self.workers = Workers(database, clock)
        self.visits = Visits(database, clock)
        self.sign_ins = SignIns(database, clock)
        self.tasks = Tasks(database, clock, draw)
        self.drafts = Drafts(database, clock)
        self.texts = Texts(database)
        self.verifications = Verifications(database)
        self.submissions = Submissions(database, clock)
        self.reviews = Reviews(database, clock)
        self.removal = Removal(database, clock)
        self.ledger = Ledger(database)
        self.mail = MailQueue(database, clock)
