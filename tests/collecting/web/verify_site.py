"""A server with a collection on the tiny split, workers who are ready to verify, and their browsers without pages."""

import json
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, closing, contextmanager
from pathlib import Path
from typing import Any, Protocol

import aiohttp

from arramon_collecting.settings import read_settings
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import Instructions, Text
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.web.play.page_client import PageClient, PageServer

NAME = "people"

TEXTS: Instructions = (
    ("धारीदार लाल मग तक दो क़दम चलें और उसे उठाएँ।", "एक क़दम आगे चलें और मग रख दें।"),
    ("दाएँ मुड़कर बिंदीदार नीले टीवी तक चलें और उसे उठाएँ।", "एक क़दम आगे चलें और टीवी रख दें।"),
)

DEVICE = {"keyboard": True, "touch": False, "width": 1440, "height": 900, "frame_ms": 8.0}


class VerifySite(PageServer):
    """The server, with direct access to its database.

    Attributes:
        store: storage of the collections.
        collection: a collection in Hindi on the split "tiny".
        host: a host of it.
    """

    def __init__(self, data: Path, *more: str, **settings: object) -> None:
        super().__init__(data, "--steps", "20", *more)
        self.database = Database(f"sqlite:///{data / 'journal.db'}")
        self.store = Store(self.database, draw=lambda: 0.0)  # a known episode whenever one may come
        chosen = read_settings({"gold_share": 0.0, "min_seconds_verify": 0, "min_seconds_write": 0, **settings}, "test")
        self.collection: Collection = self.store.collections.create(NAME, "write", "hi", "tiny", chosen)
        self.host, _ = self.store.workers.invite(self.collection, role="host")

    @property
    def pages(self) -> str:
        """Address of the collection's pages in English."""
        return f"{self.site}/en/collect/{NAME}"

    def worker(self, *, ready: bool = True) -> Worker:
        """A worker who has agreed, and has passed all tests if `ready`."""
        workers = self.store.workers
        invited, _ = workers.invite(self.collection)
        workers.consent(invited, self.collection, keep_texts=True)
        if ready:
            workers.record_device(invited.worker_id, DEVICE)
            now = self.store.clock().isoformat()
            workers.record_screening(invited.worker_id, "verify", {"attempts": 0, "passed_at": now, "until": None})
            workers.record_placement(invited.worker_id)
        return workers.get(invited.worker_id)

    def text(self, author: Worker, episode_id: str = "1", **submission: Any) -> Text:
        """A submitted text."""
        task = self.store.tasks.claim_write(self.collection, author, [episode_id])
        assert task is not None
        submitted = self.store.submissions.submit_text(self.collection, task, task.task_id, TEXTS, **submission)
        assert submitted.text is not None
        return submitted.text

    def close(self) -> None:
        self.database.close()
        assert self.stop() == 0


@contextmanager
def verify_site(data: Path, *more: str, **settings: object) -> Iterator[VerifySite]:
    with closing(VerifySite(data, *more, **settings)) as site:
        yield site


class SignedInSite(Protocol):
    """What browsers need of a server: address of its pages, storage, and the collection that is verified."""

    site: str
    store: Store
    collection: Collection


class Browser:
    """A browser in which a worker or host is signed in; it follows no redirects."""

    def __init__(self, site: SignedInSite, person: Worker, session: aiohttp.ClientSession) -> None:
        self.site, self.person, self.session = site, person, session
        self.cookie = site.store.sign_ins.open(person.worker_id)
        found = site.store.sign_ins.find(person.collection, self.cookie)
        assert found is not None
        self.csrf = found.csrf
        self.pages = f"{site.site}/en/collect/{person.collection}"
        self.headers = {"Cookie": f"arramon_collect_{person.collection}={self.cookie}"}

    async def get(self, path: str) -> tuple[int, str]:
        """Status and content of a page; of a redirect its address."""
        async with self.session.get(self.pages + path, headers=self.headers, allow_redirects=False) as answer:
            return answer.status, answer.headers.get("Location") or await answer.text()

    async def post(self, path: str, **fields: str) -> tuple[int, str]:
        """Status and content of the answer to a form."""
        return await self.send(path, data={"csrf": self.csrf, **fields})

    async def post_json(self, path: str, content: object, *, csrf: str | None = None) -> tuple[int, Any]:
        headers = {"X-CSRF-Token": self.csrf if csrf is None else csrf}
        status, text = await self.send(path, json=content, headers=headers)
        return status, json.loads(text)

    async def send(self, path: str, *, headers: dict[str, str] | None = None, **what: Any) -> tuple[int, str]:
        sent = {**self.headers, **(headers or {})}
        async with self.session.post(self.pages + path, headers=sent, allow_redirects=False, **what) as answer:
            return answer.status, answer.headers.get("Location") or await answer.text()

    @asynccontextmanager
    async def socket(self, path: str, *, site: str = "") -> AsyncIterator[PageClient]:
        """The WebSocket of a page."""
        headers = {**self.headers, "Origin": site or self.site.site}
        async with self.session.ws_connect(f"{self.pages}{path}/socket", headers=headers) as connection:
            yield PageClient(connection)

    def claim(self) -> str:
        """The address of the verification that the worker is given."""
        task = self.site.store.tasks.claim_verify(self.site.collection, self.person, ())
        assert task is not None
        return f"/verify/{task.task_id}"

    async def follow(self, path: str, actions: Sequence[int] = tiny.ACTIONS) -> list[dict[str, Any]]:
        """Follow the text of a verification to its end; returns all messages."""
        async with self.socket(path) as client:
            await hello(client)
            return await client.play(tuple(actions))


async def hello(client: PageClient, **more: object) -> None:
    """What the verify page says first."""
    new = {"split": "text", "language": "en", "episodes": 0}
    await client.say(type="hello", player="c" * 32, size=224, token="", **{"new": new, **more})


@asynccontextmanager
async def browsers(site: SignedInSite, *people: Worker) -> AsyncIterator[list[Browser]]:
    """A browser for each person."""
    async with aiohttp.ClientSession(cookie_jar=aiohttp.DummyCookieJar()) as session:
        yield [Browser(site, person, session) for person in people]
