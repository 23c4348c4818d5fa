"""The leaderboard's pages: their addresses, and who makes each. None is made on the event loop that plays episodes."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar
from urllib.parse import quote

from aiohttp import web

from server.board.board import Board
from server.board.exports import as_csv, as_json
from server.episodes.splits import Split
from server.errors import NotFound, Unavailable
from server.runs.callers import STRANGER
from server.runs.journal import Journal
from server.runs.receipts import Receipts
from server.web.choices import read_choice
from server.web.paths import Paths
from server.web.rendering import Renderer
from server.web.responses import FOR_EVER, answer, moved
from server.web.run_page import RunPage
from server.web.standings_page import StandingsPage
from server.web.texts import Texts, all_texts, preferred

MAX_WAITING = 64
"""Requests that may wait for a thread at a time; what comes beyond is asked to come again."""

RETRY_SECONDS = 2
"""After which it may come again."""

RECEIPT_FORMAT, RECEIPT_VERSION = "arramon-receipt-file", 1
"""Of a receipt's file, as `arramon-client verify` reads it."""

_LANGUAGE = "{language:[a-z]{2,3}}"
_RUN = "{run:[0-9a-f]{32}}"

T = TypeVar("T")
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Pages:
    """All pages. Only published runs have any; for all else the answer is 404, always in the same words.

    Args:
        board: how the runs stand.
        journal: has their episodes.
        receipts: has their receipts.
        splits: what is served, by name.
    """

    def __init__(self, board: Board, journal: Journal, receipts: Receipts, splits: Mapping[str, Split]) -> None:
        self._board = board
        self._receipts = receipts
        self._renderer = Renderer()
        self._standings = StandingsPage(board, splits)
        self._played = Paths(splits, journal)
        self._runs = RunPage(board, splits, self._played)
        # One thread for pages, which are quick, and one for paths, which take a moment: these never hold up those.
        self._pages = ThreadPoolExecutor(1, "pages")
        self._paths = ThreadPoolExecutor(1, "paths")
        self._waiting = 0
        self._apologies: dict[tuple[str, str, str], bytes] = {}

    def routes(self) -> list[web.RouteDef]:
        """All addresses, the last of which takes whatever is nowhere else."""
        run = f"/{_LANGUAGE}/runs/{_RUN}"
        handlers = {
            "/": self._home,
            f"/{_LANGUAGE}/": self._list,
            f"/{_LANGUAGE}": self._slash,
            run: self._run,
            f"{run}/episodes": self._find,
            f"{run}/episodes/{{episode}}": self._episode,
            f"/runs/{_RUN}/receipt.json": self._receipt,
            "/standings.{form:csv|json}": self._download,
            "/static/{name}": self._static,
            "/{rest:.*}": self._nowhere,
        }
        return [web.get(path, self._guarded(handler)) for path, handler in handlers.items()]

    def close(self) -> None:
        """Takes no more work, and lets its threads go."""
        self._pages.shutdown(wait=False, cancel_futures=True)
        self._paths.shutdown(wait=True, cancel_futures=True)
        self._played.close()

    def _guarded(self, handler: Handler) -> Handler:
        """Turns the server's errors into pages."""

        async def guarded(request: web.Request) -> web.StreamResponse:
            try:
                return await handler(request)
            except NotFound:
                return self._missing(request)
            except _Busy:
                return self._sorry(request, "missing.busy")
            except Unavailable:
                return self._sorry(request, "missing.unavailable")

        return guarded

    async def _home(self, request: web.Request) -> web.Response:
        language = preferred(request.headers.get("Accept-Language", ""))
        return moved(f"/{language}/{_query(request)}", varies="Accept-Language")

    async def _slash(self, request: web.Request) -> web.Response:
        return moved(f"/{_texts(request).language}/{_query(request)}")

    async def _list(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            usual = self._standings.usual(texts.language)
            choice = read_choice(request.query, self._board.languages(), usual)
            context = self._standings.context(texts, choice, usual)
            return self._page(request, "standings.html", texts, context)

        return await self._in(self._pages, make)

    async def _download(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            usual = self._standings.usual(preferred(""))
            choice = read_choice(request.query, self._board.languages(), usual)
            listing = self._board.listing(choice.split, choice.language, choice.metric)
            form = request.match_info["form"]
            text, kind = (as_csv(listing), "text/csv") if form == "csv" else (as_json(listing), "application/json")
            name = f"arramon-{choice.split}-{choice.language}.{form}"
            return answer(request, text.encode(), kind, name=name)

        return await self._in(self._pages, make)

    async def _run(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context = self._runs.context(texts, request.match_info["run"])
            return self._page(request, "run.html", texts, context)

        return await self._in(self._pages, make)

    async def _find(self, request: web.Request) -> web.Response:
        """From the form on a run's page, which works without scripts, to an episode's address."""
        _texts(request)
        episode = request.query.get("episode", "").strip()
        return moved(f"{request.path}/{quote(episode, safe='')}")

    async def _episode(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context = self._runs.episode_context(texts, request.match_info["run"], request.match_info["episode"])
            return self._page(request, "episode.html", texts, context)

        return await self._in(self._paths, make)

    async def _receipt(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            entry = self._board.entry(request.match_info["run"])
            if entry.seal is None:
                raise NotFound("this run has no receipt")
            run_id = entry.run.run_id
            receipt = self._receipts.of(STRANGER, run_id)
            content = {
                "format": RECEIPT_FORMAT,
                "version": RECEIPT_VERSION,
                "payload": receipt.payload.decode(),
                "signature": receipt.signature.hex(),
                "public_key": receipt.public_key.hex(),
            }
            body = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
            return answer(request, body.encode(), "application/json", name=f"{run_id}.receipt.json")

        return await self._in(self._pages, make)

    async def _static(self, request: web.Request) -> web.Response:
        found = self._renderer.files.get(request.match_info["name"])
        if found is None:
            raise NotFound("there is no such file")
        return answer(request, *found, cache=FOR_EVER)

    async def _nowhere(self, _request: web.Request) -> web.Response:
        raise NotFound("there is no such page")

    async def _in(self, executor: ThreadPoolExecutor, work: Callable[[], T]) -> T:
        if self._waiting >= MAX_WAITING:
            raise _Busy
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(executor, work)
        finally:
            self._waiting -= 1

    def _page(self, request: web.Request, template: str, texts: Texts, context: Mapping[str, object]) -> web.Response:
        here = request.rel_url.raw_path_qs.removeprefix(f"/{texts.language}")
        return answer(request, self._renderer.page(template, texts, here, context), "text/html")

    def _kept(self, template: str, texts: Texts, key: str = "") -> bytes:
        """A page that says that there is none; it is the same for everybody."""
        which = (template, texts.language, key)
        if which not in self._apologies:
            self._apologies[which] = self._renderer.page(template, texts, "/", {"key": key})
        return self._apologies[which]

    def _missing(self, request: web.Request) -> web.Response:
        page = self._kept("missing.html", _told(request))
        return answer(request, page, "text/html", status=404, varies="Accept-Encoding, Accept-Language")

    def _sorry(self, request: web.Request, key: str) -> web.Response:
        texts = _told(request)
        page = self._kept("sorry.html", texts, key)
        response = answer(request, page, "text/html", status=503, cache="no-store")
        response.headers["Retry-After"] = str(RETRY_SECONDS)
        return response


class _Busy(Exception):
    """More is asked for than the threads can do."""


def _query(request: web.Request) -> str:
    """As it came, from its question mark on; empty where there is none."""
    query = request.rel_url.raw_query_string
    return f"?{query}" if query else ""


def _texts(request: web.Request) -> Texts:
    """The texts of the language that a page's address begins with.

    Raises:
        NotFound: if there is none.
    """
    try:
        return all_texts()[request.match_info["language"]]
    except KeyError:
        raise NotFound("there is no such language") from None


def _told(request: web.Request) -> Texts:
    """The texts for an answer that may stand at any address."""
    first = request.path.removeprefix("/").partition("/")[0]
    language = first if first in all_texts() else preferred(request.headers.get("Accept-Language", ""))
    return all_texts()[language]
