"""The pages of one collection on a free loopback port, and a browser that keeps cookies and sends forms."""

import http.client
import json
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode

from aiohttp import web

from arramon_collecting.web import part
from arramon_collecting.web.handlers import Handlers
from arramon_collecting.web.people.join_pages import JoinPages
from arramon_collecting.web.people.worker_pages import WorkerPages
from arramon_server.episodes.splits import Split
from arramon_server.errors import Unauthenticated
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import Run
from arramon_server.web.play.browser_access import BrowserAccess
from arramon_server.web.rendering import Renderer
from tests import tiny
from tests.collecting.collecting import Field
from tests.web.serving import Site

HOST_TOKEN = "token-of-a-host"


async def authenticate(_: web.BaseRequest, token: str) -> Caller:
    """Know one token of a host, and one of a participant."""
    roles = {HOST_TOKEN: Role.HOST, "token-of-a-participant": Role.PARTICIPANT}
    if token not in roles:
        raise Unauthenticated("the token is not known")
    return Caller(roles[token], "Asha")


@asynccontextmanager
async def count_stream(_: Caller, __: Run, ___: str) -> AsyncIterator[None]:
    """Count no streams."""
    yield


class CollectingSite:
    """A collection and its pages."""

    def __init__(self, folder: Path, **settings: object) -> None:
        self.splits: dict[str, Split] = {"sample": tiny.write(folder / "data", "sample")}
        self.field = Field(Database(f"sqlite:///{folder / 'journal.db'}"), **settings)
        renderer = Renderer()
        renderer.add_folder(part.NAME, Path(part.__file__).parent)
        self._handlers = Handlers(self.field.store, renderer)
        access = BrowserAccess(authenticate, count_stream, needs_token=True)
        self._pages = (JoinPages(self._handlers, access), WorkerPages(self._handlers, self.splits))
        self.site = Site(self)  # type: ignore[arg-type]

    def routes(self) -> list[web.RouteDef]:
        return [route for pages in self._pages for route in pages.routes()]

    def close(self) -> None:
        if self.site is not None:
            site, self.site = self.site, None  # type: ignore[assignment]
            site.close()  # closes this again
            return
        self._handlers.close()
        self.field.database.close()

    def browser(self) -> "Browser":
        return Browser(self.site.port)

    def invited(self, **values: str) -> tuple["Browser", str]:
        """Return a browser in which a new worker has opened the personal link, and the worker's id."""
        worker, key = self.field.store.workers.invite(self.field.collection, **values)
        browser = self.browser()
        assert browser.get(f"/en/collect/col/join?key={key}").status == 303
        return browser, worker.worker_id

    def consented(self, **values: str) -> tuple["Browser", str]:
        """Return a browser of a worker who has agreed and has nothing more to show before tasks."""
        browser, worker_id = self.invited(**values)
        browser.get("/en/collect/col/")
        browser.post("/en/collect/col/consent", **CONSENT, consent_hash=self.field.collection.consent_hash)
        self.ready(worker_id)
        return browser, worker_id

    def ready(self, worker_id: str) -> None:
        workers = self.field.store.workers
        workers.record_device(worker_id, {"keyboard": True})
        for stage in ("write", "verify"):
            workers.record_screening(worker_id, stage, {"passed_at": "2026-11-01T12:00:00+00:00"})
        workers.record_placement(worker_id)


CONSENT = {"agree": "yes", "keep_texts": "yes"}


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    text: str

    @property
    def location(self) -> str:
        return self.headers.get("location", "")


class Browser:
    """Keeps cookies, and repeats the value against forged requests of the last page."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.cookies: dict[str, str] = {}
        self.csrf = ""
        self.set_cookie = self.origin = ""

    def get(self, path: str, **headers: str) -> Answer:
        answer = self._request("GET", path, None, headers)
        if found := re.search(r'name="csrf" value="([^"]+)"', answer.text):
            self.csrf = found[1]
        return answer

    def post(self, path: str, **fields: str) -> Answer:
        return self.send(path, urlencode({"csrf": self.csrf} | fields).encode())

    def send_json(self, path: str, content: object) -> Answer:
        """Send what a script sends."""
        headers = {"Content-Type": "application/json", "X-CSRF-Token": self.csrf}
        return self._request("POST", path, json.dumps(content).encode(), headers)

    def send(self, path: str, body: bytes) -> Answer:
        """Send a form as it is given."""
        headers = {"Content-Type": "application/x-www-form-urlencoded"}
        return self._request("POST", path, body, headers | ({"Origin": self.origin} if self.origin else {}))

    def _request(self, method: str, path: str, body: bytes | None, headers: dict[str, str]) -> Answer:
        if self.cookies:
            headers = headers | {"Cookie": "; ".join(f"{name}={value}" for name, value in self.cookies.items())}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        try:
            connection.request(method, path, body, headers)
            response = connection.getresponse()
            text = response.read().decode()
            found = {name.lower(): value for name, value in response.getheaders()}
        finally:
            connection.close()
        if "set-cookie" in found:
            self.set_cookie = found["set-cookie"]
            name, _, value = self.set_cookie.partition(";")[0].partition("=")
            if value.strip('"'):
                self.cookies[name] = value
            else:
                self.cookies.pop(name, None)
        return Answer(response.status, found, text)
