"""A server with a collection on the tiny split, and writers who are signed in, without a browser."""

import http.client
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from arramon_collecting.settings import read_settings
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.work.records import Task
from arramon_collecting.web.access import cookie_name
from arramon_server.runs.storage.database import Database
from tests.web.play.page_client import PageServer

EDITOR, OTHER_EDITOR = "a" * 32, "b" * 32
SUBMISSION = "c" * 32

DONE_AT = "3.0.0.2.0.4"
"""Position of a writer who has been through all parts of a tiny episode."""

TEXTS = (
    "Walk straight ahead to the brick building and pick up the striped red mug.",
    "Place the striped red mug in front of the brick wall, straight ahead of you.",
    "Turn right, walk along the brick building and pick up the dotted blue tv.",
    "Place the dotted blue tv on top of the striped red mug.",
)


@dataclass(frozen=True)
class Answer:
    """An answer of the server."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> dict[str, Any]:
        content: dict[str, Any] = json.loads(self.body)
        return content

    @property
    def text(self) -> str:
        return self.body.decode()


class Writer:
    """A worker who is signed in, with an open task.

    Attributes:
        page: address of the task's page.
    """

    def __init__(self, site: "WriteSite", collection: Collection, worker: Worker, task: Task) -> None:
        self.site, self.collection, self.worker, self.task = site, collection, worker, task
        self.cookie = site.store.sign_ins.open(worker.worker_id)
        found = site.store.sign_ins.find(collection.name, self.cookie)
        assert found is not None
        self.csrf = found.csrf
        self.page = f"/en/collect/{collection.name}/write/{task.task_id}"

    def get(self, path: str = "", **query: str) -> Answer:
        address = f"{self.page}{path}" + (f"?{urlencode(query)}" if query else "")
        return self.request("GET", address, headers={"Accept": "application/json"} if path else {})

    def post(self, path: str, content: object, **headers: str) -> Answer:
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        return self.request("POST", f"{self.page}{path}", body, {"Content-Type": "application/json", **headers})

    def request(
        self, method: str, address: str, body: bytes | None = None, headers: Mapping[str, str] | None = None
    ) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.site.port, timeout=120)
        cookie = f"{cookie_name(self.collection.name)}={self.cookie}"
        sent = {"Cookie": cookie, "X-CSRF-Token": self.csrf, **(headers or {})}
        try:
            connection.request(method, address, body, {name: value for name, value in sent.items() if value})
            response = connection.getresponse()
            return Answer(response.status, dict(response.getheaders()), response.read())
        finally:
            connection.close()

    def written(self, texts: tuple[str, ...] = TEXTS, **more: object) -> dict[str, Any]:
        """What a page sends of a task."""
        return {"editor": EDITOR, "position": DONE_AT, "texts": list(texts), "evidence": {}, **more}

    def open(self, editor: str = EDITOR) -> dict[str, Any]:
        answer = self.post("/open", {"editor": editor})
        assert answer.status == 200, answer.text
        return answer.json

    def submit(self, texts: tuple[str, ...] = TEXTS, submission: str = SUBMISSION, **more: object) -> Answer:
        return self.post("/submit", self.written(texts, submission=submission, **more))


class WriteSite(PageServer):
    """The server, and the storage that it uses.

    Attributes:
        collection: the latest collection.
    """

    collection: Collection

    def __init__(self, data: Path, *more: str, environment: Mapping[str, str] | None = None) -> None:
        super().__init__(data, *more, environment=environment)
        self.port = int(self.site.rpartition(":")[2])
        self.database = Database(f"sqlite:///{data / 'journal.db'}")
        self.store = Store(self.database)
        self._collections = 0

    def writer(self, language: str = "en", **settings: object) -> Writer:
        """Return a writer with an open task in a collection of its own."""
        self._collections += 1
        chosen = read_settings({"min_seconds_write": 0, "max_characters": 200, **settings}, "test")
        name = f"col{self._collections}"
        self.collection = collection = self.store.collections.create(name, "write", language, "tiny", chosen)
        return self.another_writer(collection)

    def another_writer(self, collection: Collection) -> Writer:
        """Return a writer with an open task in an existing collection."""
        worker = self.worker(collection)
        task = self.store.tasks.claim_write(collection, worker, ["1", "2"])
        assert task is not None
        return Writer(self, collection, worker, task)

    def worker(self, collection: Collection) -> Worker:
        """Return a worker who has agreed."""
        invited, _ = self.store.workers.invite(collection)
        self.store.workers.consent(invited, collection, keep_texts=True)
        return self.store.workers.get(invited.worker_id)
