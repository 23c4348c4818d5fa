"""Collections for tests: a store with a clock that tests set, workers who have agreed, and texts."""

from datetime import UTC, datetime, timedelta

from arramon_collecting.settings import Settings, read_settings
from arramon_collecting.storage.mail_queue import Letter
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import Instructions
from arramon_collecting.storage.work.records import Task
from arramon_collecting.storage.work.submissions import Play, Submission
from arramon_server.runs.storage.database import Database

TEXTS: Instructions = (
    ("Turn left and walk to the dotted red bucket, then pick it up.", "Place the bucket behind the striped white mug."),
    ("Turn right at the bank and collect the blue hourglass.", "Put the hourglass on the left of the red bucket."),
)

EPISODES = tuple(f"e{number}" for number in range(12))

WELL, BADLY = (0.9, 0.8), (0.1, 0.8)
"""Scores nDTW with which a verifier succeeds, and does not."""


class FakeClock:
    """A clock that stands still, and goes on when it is told to."""

    def __init__(self) -> None:
        self.now = datetime(2026, 11, 1, 12, tzinfo=UTC)

    def __call__(self) -> datetime:
        return self.now

    def advance(self, **by: float) -> None:
        self.now += timedelta(**by)


class Field:
    """A collection with its store, and shortcuts for what tests do often."""

    def __init__(self, database: Database, **settings: object) -> None:
        self.clock = FakeClock()
        self.draws: list[float] = []
        self.database = database
        self.store = Store(self.database, self.clock, lambda: self.draws.pop(0) if self.draws else 0.99)
        chosen: Settings = read_settings({"gold_share": 0.0, "min_seconds_write": 0, **settings}, "test")
        self.collection: Collection = self.store.collections.create("col", "write", "en", "sample", chosen)

    def worker(self, **values: str) -> Worker:
        """Invite a worker, who agrees."""
        invited, _ = self.store.workers.invite(self.collection, **values)
        self.store.workers.consent(invited, self.collection, keep_texts=True)
        return self.store.workers.get(invited.worker_id)

    def claim(self, worker: Worker) -> Task:
        """Give out an episode to write for."""
        task = self.store.tasks.claim_write(self.collection, worker, EPISODES)
        assert task is not None
        return task

    def write(self, worker: Worker, texts: Instructions = TEXTS, **values: object) -> Submission:
        """Give out an episode, and submit a text for it."""
        task = self.claim(worker)
        return self.store.submissions.submit_text(self.collection, task, task.task_id, texts, **values)  # type: ignore[arg-type]

    def verify(
        self, worker: Worker, ndtw: tuple[float, ...] = WELL, flags: tuple[str, ...] = (), seconds: float = 60.0
    ) -> Submission:
        """Give out a text, and submit a verification of it."""
        task = self.store.tasks.claim_verify(self.collection, worker, ())
        assert task is not None
        play = Play("0" * 32, ndtw, (1.0, 1.0), (None, (1, 0, 2)), (((0.0, 0.0),), ()), flags, seconds)
        return self.store.submissions.submit_verification(self.collection, task, task.task_id, play)

    def owed(self, worker: Worker) -> int:
        """Return what the collection owes a worker."""
        return self.store.ledger.total_of(worker.worker_id)


def fill(database: Database) -> None:
    """Add rows to each table of collections."""
    made = Field(database, smtp={"host": "localhost"})
    author, host = made.worker(email="ann@example.org"), made.worker(role="host")
    made.store.visits.begin(author.worker_id, "study", "session")
    made.write(author)
    made.verify(made.worker())
    (text,) = made.store.texts.all("col")
    made.store.reviews.send_back(
        made.collection, text.text_id, 1, host, "unclear", Letter("Your text", "It is unclear.")
    )
    made.store.sign_ins.open(author.worker_id)
    made.store.drafts.save(made.claim(author), 0, {"texts": []}, size=12)
