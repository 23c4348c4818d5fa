"""Routes and handlers of the leaderboard's pages. Pages are rendered in threads, off the engine's event loop."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar
from urllib.parse import quote

from aiohttp import web

from arramon_server.board.board import Board
from arramon_server.board.epoch_board import EpochBoard, epoch_list_file
from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.people import PeopleBoard
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict, Forbidden, NotFound, Unauthenticated, Unavailable
from arramon_server.runs.accounts.callers import READER
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.cameras import CAMERAS
from arramon_server.web.comparison_page import ComparisonPage
from arramon_server.web.episode_replays import EpisodeReplays
from arramon_server.web.episodes_page import EpisodesPage
from arramon_server.web.epochs_page import EpochsPage
from arramon_server.web.host import UNNAMED, Host
from arramon_server.web.http_responses import DAY, FOR_EVER, PRIVATE, SHORT, redirect, respond
from arramon_server.web.page_texts import PageTexts, all_texts, preferred_language
from arramon_server.web.play.people_page import PeoplePage
from arramon_server.web.play.play_page import PICTURES, SOCKET, PlayPage
from arramon_server.web.rendering import Renderer
from arramon_server.web.run_page import RunPage
from arramon_server.web.server_options import ServerOptions
from arramon_server.web.standings_page import StandingsPage
from arramon_server.web.standings_query import read_query
from arramon_server.web.watch.sign_in import check_same_origin, keep_pass
from arramon_server.web.watch.viewers import NOBODY, Viewers
from arramon_server.web.watch.watch_pages import WatchPages
from arramon_server.web.web_parts import WebPart

MAX_WAITING = 64
"""Maximum number of requests that wait for a thread or run in one; further ones get status 503."""

RETRY_SECONDS = 2
"""`Retry-After` of a 503 response."""

RECEIPT_FORMAT, RECEIPT_VERSION = "arramon-receipt-file", 1
"""Header of a receipt file, which `arramon-client verify` reads."""

ACTIONS_FORMAT, ACTIONS_VERSION = "arramon-actions", 1
"""Header of a file with a run's actions, which `arramon-server rescore` reads."""

_LANGUAGE = "{language:[a-z]{2,3}}"
_RUN = "{run:[0-9a-f]{32}}"

T = TypeVar("T")
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Pages:
    """All pages.

    Only published runs have pages, but for those that a caller may see and watch (`WatchedRuns`); every other address
    gets the same 404 page.

    Args:
        board: the leaderboard.
        journal: source of the runs' episodes.
        receipts: issues the runs' receipts.
        splits: the splits served, by name.
        epochs: the epochs of hidden splits.
        host: the host of the leaderboard.
        play: makes the page on which people play; None if the host offers none.
        parts: opens the parts that installed packages add.
        viewers: derives who asks for pages of runs that are not published.
        camera: camera of the server's runs.
        server: options with which clients reach the server.
    """

    def __init__(
        self,
        board: Board,
        journal: Journal,
        receipts: Receipts,
        splits: Mapping[str, Split],
        epochs: EpochBoard,
        host: Host = UNNAMED,
        *,
        play: Callable[[Renderer], PlayPage] | None = None,
        parts: Callable[[Renderer], Sequence[WebPart]] = lambda _: (),
        viewers: Viewers = NOBODY,
        camera: str = CAMERAS[0],
        server: ServerOptions | None = None,
    ) -> None:
        self._board = board
        self._server = server if server is not None else ServerOptions(viewers=viewers)
        self._epochs = epochs
        self._receipts = receipts
        self._renderer = Renderer(host, offers_play=play is not None)
        self._play = play(self._renderer) if play is not None else None
        self._parts = parts(self._renderer)
        self._standings = StandingsPage(board, splits, epochs)
        self._epochs_page = EpochsPage(board, epochs)
        self._comparisons = ComparisonPage(board)
        self._people = PeoplePage(board, PeopleBoard(board, journal, splits))
        self._replays = EpisodeReplays(splits, journal)
        self._runs = RunPage(board, splits, self._replays, epochs)
        self._episodes = EpisodesPage(board, self._replays)
        self._watch = WatchPages(splits, journal, board, viewers, camera)
        # One thread for pages, which are quick, and one for paths, which are slower, so that paths never delay pages.
        self._page_thread = ThreadPoolExecutor(1, "pages")
        self._path_thread = ThreadPoolExecutor(1, "paths")
        self._waiting = 0
        self._error_pages: dict[tuple[str, str, str], bytes] = {}

    def routes(self) -> list[web.RouteDef]:
        """Return all routes; the last one matches every remaining address."""
        run = f"/{_LANGUAGE}/runs/{_RUN}"
        handlers = {
            "/": self._home,
            f"/{_LANGUAGE}/": self._standings_list,
            f"/{_LANGUAGE}": self._redirect_to_slash,
            f"/{_LANGUAGE}/epochs": self._list_epochs,
            run: self._run,
            f"{run}/against": self._comparison_page,
            f"{run}/episodes": self._list_episodes,
            f"{run}/episodes/{{episode}}": self._episode,
            f"{run}/episodes/{{episode}}/moments.json": self._moments,
            f"{run}/failures": self._list_failures,
            f"{run}/differences": self._list_differences,
            f"/{_LANGUAGE}/watch": self._list_watched,
            f"/runs/{_RUN}/episodes/{{episode}}/frames/{{step:[0-9]{{1,7}}}}.jpg": self._frame,
            f"/runs/{_RUN}/receipt.json": self._receipt,
            f"/runs/{_RUN}/actions.json": self._actions,
            "/epochs.json": self._epochs_file,
            "/standings.{form:csv|json}": self._download,
            "/static/{name}": self._static,
            "/static/{folder}/{name}": self._static,
            "/{rest:.*}": self._not_found,
        }
        routes = [route for part in self._parts for route in part.routes()]
        routes += [web.get(path, self._with_error_pages(handler)) for path, handler in handlers.items()]
        if self._watch.can_sign_in:
            routes += [
                web.post(f"/{_LANGUAGE}/watch/{name}", self._with_error_pages(handler))
                for name, handler in {"sign-in": self._sign_in, "sign-out": self._sign_out}.items()
            ]
        if self._play is None:
            return routes
        play = web.get(f"/{_LANGUAGE}/play", self._with_error_pages(self._play_page))
        people = web.get(f"/{_LANGUAGE}/people", self._with_error_pages(self._people_page))
        picture = web.get(f"{PICTURES}/{{thing:[a-z_]+}}.jpg", self._with_error_pages(self._play_picture))
        return [play, people, picture, web.get(SOCKET, self._play.serve_socket), *routes]

    def close(self) -> None:
        """Stop accepting work, and end the threads."""
        self._page_thread.shutdown(wait=False, cancel_futures=True)
        self._path_thread.shutdown(wait=True, cancel_futures=True)
        self._replays.close()
        if self._play is not None:
            self._play.close()
        self._watch.close()
        for part in self._parts:
            part.close()

    def _with_error_pages(self, handler: Handler) -> Handler:
        """Return a handler that turns the server's errors into error pages."""

        async def guarded(request: web.Request) -> web.StreamResponse:
            try:
                return await handler(request)
            except NotFound:
                return self._not_found_page(request)
            except _Busy:
                return self._unavailable_page(request, "missing.busy")
            except Unavailable:
                return self._unavailable_page(request, "missing.unavailable")

        return guarded

    async def _home(self, request: web.Request) -> web.Response:
        language = preferred_language(request.headers.get("Accept-Language", ""))
        return redirect(f"/{language}/{_query(request)}", varies="Accept-Language")

    async def _redirect_to_slash(self, request: web.Request) -> web.Response:
        return redirect(f"/{_texts(request).language}/{_query(request)}")

    async def _standings_list(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            defaults = self._standings.defaults(texts.language)
            choice = read_query(request.query, self._board.languages(), defaults)
            context = self._standings.context(texts, choice, defaults, self._server.text(request))
            return self._page(request, "standings.html", texts, context)

        return await self._run_in(self._page_thread, make)

    async def _download(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            defaults = self._standings.defaults(preferred_language(""))
            choice = read_query(request.query, self._board.languages(), defaults)
            listing = self._board.listing(choice.split, choice.language, choice.metric)
            form = request.match_info["form"]
            text, kind = (as_csv(listing), "text/csv") if form == "csv" else (as_json(listing), "application/json")
            name = f"arramon-{choice.split}-{choice.language}.{form}"
            return respond(request, text.encode(), kind, name=name)

        return await self._run_in(self._page_thread, make)

    async def _run(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context = self._runs.context(texts, request.match_info["run"])
            return self._page(request, "run.html", texts, context)

        return await self._run_in(self._page_thread, make)

    async def _comparison_page(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context = self._comparisons.context(texts, request.match_info["run"], request.query)
            return self._page(request, "against.html", texts, context)

        return await self._run_in(self._page_thread, make)

    async def _list_episodes(self, request: web.Request) -> web.Response:
        """Return the list, or redirect to the episode that the form on the page names."""
        texts = _texts(request)
        if episode := request.query.get("episode", "").strip():
            return redirect(f"{request.path}/{quote(episode, safe='')}")

        def make() -> web.Response:
            context = self._episodes.context(texts, request.match_info["run"], request.query)
            return self._page(request, "episodes.html", texts, context)

        return await self._run_in(self._page_thread, make)

    async def _episode(self, request: web.Request) -> web.Response:
        find = self._watch.find(request)

        def make() -> web.Response:
            texts = _texts(request)
            if "with" in request.query:
                context, is_private = self._watch.pair(texts, request)
                return self._watch_page(request, "watch_pair.html", texts, context, is_private=is_private)
            watched = find()
            is_private = self._watch.is_private(request, watched.watched)
            context = self._watch.context(texts, request, watched)
            if watched.watched.entry is None or watched.watched.split.hidden:
                return self._watch_page(request, "watch.html", texts, context, is_private=is_private)
            run, episode = request.match_info["run"], request.match_info["episode"]
            context |= self._episodes.episode_context(texts, run, episode, request.query)
            return self._watch_page(request, "episode.html", texts, context, is_private=is_private)

        return await self._run_in(self._path_thread, make)

    async def _moments(self, request: web.Request) -> web.Response:
        return await self._run_in(self._path_thread, self._watch.moments(request, _texts(request)))

    async def _frame(self, request: web.Request) -> web.Response:
        return await self._watch.frame(request, lambda work: self._run_in(self._path_thread, work))

    async def _list_failures(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context, is_private = self._watch.failures(texts, request)
            return self._watch_page(request, "failures.html", texts, context, is_private=is_private)

        return await self._run_in(self._watch.failures_thread, make)

    async def _list_differences(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            context, is_private = self._watch.differences(texts, request)
            return self._watch_page(request, "differences.html", texts, context, is_private=is_private)

        return await self._run_in(self._path_thread, make)

    async def _list_watched(self, request: web.Request, problem: str = "") -> web.Response:
        texts, list_runs = _texts(request), self._watch.listed(request)

        def make() -> web.Response:
            context = {**list_runs(), "problem": problem}
            status = 403 if problem else 200
            return self._watch_page(request, "watch_runs.html", texts, context, is_private=True, status=status)

        return await self._run_in(self._path_thread, make)

    async def _sign_in(self, request: web.Request) -> web.Response:
        """Exchange the token in a form for a cookie, and redirect to the runs of its participant."""
        sign_in, texts = self._watch.sign_in, _texts(request)
        try:
            watch_pass = await sign_in.issue(request)
        except Unauthenticated:
            return await self._list_watched(request, "watch.refused_token")
        except Forbidden:
            return await self._list_watched(request, "watch.refused_connection")
        response = redirect(f"/{texts.language}/watch")
        keep_pass(request, response, watch_pass)
        return response

    async def _sign_out(self, request: web.Request) -> web.Response:
        texts = _texts(request)
        try:
            check_same_origin(request)
        except Forbidden:
            return await self._list_watched(request, "watch.refused_connection")
        response = redirect(f"/{texts.language}/watch")
        keep_pass(request, response, "")
        return response

    async def _receipt(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            entry = self._board.entry(request.match_info["run"])
            if entry.receipt_fingerprint is None or entry.frozen:
                raise NotFound("this run has no receipt to show")
            run_id, number = entry.run.run_id, request.query.get("number", "0")
            if not (number.isascii() and number.isdecimal() and len(number) < 6):
                raise NotFound("there is no receipt of that number")
            receipt = self._receipts.of(READER, run_id, int(number))
            content = {
                "format": RECEIPT_FORMAT,
                "version": RECEIPT_VERSION,
                "payload": receipt.payload.decode(),
                "signature": receipt.signature.hex(),
                "public_key": receipt.public_key.hex(),
            }
            name = f"{run_id}.receipt.json" if number == "0" else f"{run_id}.{number}.receipt.json"
            return _json(request, content, name)

        return await self._run_in(self._page_thread, make)

    async def _play_page(self, request: web.Request) -> web.Response:
        texts, play = _texts(request), self._play
        assert play is not None

        def make() -> web.Response:
            return self._page(request, "play.html", texts, play.context(texts))

        return await self._run_in(self._page_thread, make)

    async def _play_picture(self, request: web.Request) -> web.Response:
        play = self._play
        assert play is not None
        return await self._run_in(
            self._path_thread,
            lambda: respond(request, play.picture(request.match_info["thing"]), "image/jpeg", cache=DAY),
        )

    async def _people_page(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            return self._page(request, "people.html", texts, self._people.context(texts, request.query))

        return await self._run_in(self._path_thread, make)

    async def _list_epochs(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            texts = _texts(request)
            return self._page(request, "epochs.html", texts, self._epochs_page.context(texts, request.query))

        return await self._run_in(self._page_thread, make)

    async def _epochs_file(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            return _json(request, epoch_list_file(self._epochs.all()), "epochs.json")

        return await self._run_in(self._page_thread, make)

    async def _actions(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            run_id = request.match_info["run"]
            try:
                actions = self._epochs.actions(run_id)
            except Conflict:
                raise NotFound("the actions of this run are not public") from None
            digits = {name: "".join(map(str, taken)) for name, taken in actions.items()}
            content = {"format": ACTIONS_FORMAT, "version": ACTIONS_VERSION, "run": {"run_id": run_id}}
            return _json(request, {**content, "actions": digits}, f"{run_id}.actions.json")

        return await self._run_in(self._path_thread, make)

    async def _static(self, request: web.Request) -> web.Response:
        parts = (request.match_info.get("folder"), request.match_info["name"])
        found = self._renderer.files.get("/".join(filter(None, parts)))
        if found is None:
            raise NotFound("there is no such file")
        return respond(request, *found, cache=FOR_EVER)

    async def _not_found(self, _request: web.Request) -> web.Response:
        raise NotFound("there is no such page")

    async def _run_in(self, executor: ThreadPoolExecutor, work: Callable[[], T]) -> T:
        if self._waiting >= MAX_WAITING:
            raise _Busy
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(executor, work)
        finally:
            self._waiting -= 1

    def _page(
        self, request: web.Request, template: str, texts: PageTexts, context: Mapping[str, object]
    ) -> web.Response:
        here = request.rel_url.raw_path_qs.removeprefix(f"/{texts.language}")
        return respond(request, self._renderer.page(template, texts, here, context), "text/html")

    def _watch_page(
        self,
        request: web.Request,
        template: str,
        texts: PageTexts,
        context: Mapping[str, object],
        *,
        is_private: bool,
        status: int = 200,
    ) -> web.Response:
        """Return a page that depends on who has signed in."""
        is_form = request.method == "POST"  # Its own address shows nothing.
        here = "/watch" if is_form else request.rel_url.raw_path_qs.removeprefix(f"/{texts.language}")
        page = self._renderer.page(template, texts, here, context)
        cache = PRIVATE if is_private else SHORT
        return respond(request, page, "text/html", status=status, cache=cache, varies="Accept-Encoding, Cookie")

    def _error_page(self, template: str, texts: PageTexts, key: str = "") -> bytes:
        """Return an error page. It is cached, because it is the same for all requests in a language."""
        page_key = (template, texts.language, key)
        if page_key not in self._error_pages:
            self._error_pages[page_key] = self._renderer.page(template, texts, "/", {"key": key})
        return self._error_pages[page_key]

    def _not_found_page(self, request: web.Request) -> web.Response:
        page = self._error_page("missing.html", _error_texts(request))
        return respond(request, page, "text/html", status=404, varies="Accept-Encoding, Accept-Language, Cookie")

    def _unavailable_page(self, request: web.Request, key: str) -> web.Response:
        texts = _error_texts(request)
        page = self._error_page("sorry.html", texts, key)
        response = respond(request, page, "text/html", status=503, cache="no-store")
        response.headers["Retry-After"] = str(RETRY_SECONDS)
        return response


class _Busy(Exception):
    """Too many requests are waiting for the threads."""


def _json(request: web.Request, content: object, name: str) -> web.Response:
    """Return a JSON file for download."""
    body = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
    return respond(request, body.encode(), "application/json", name=name)


def _query(request: web.Request) -> str:
    """Return the unparsed query with its question mark; empty if there is none."""
    query = request.rel_url.raw_query_string
    return f"?{query}" if query else ""


def _texts(request: web.Request) -> PageTexts:
    """Return the texts in the language that a page's address begins with.

    Raises:
        NotFound: if there is no such language.
    """
    try:
        return all_texts()[request.match_info["language"]]
    except KeyError:
        raise NotFound("there is no such language") from None


def _error_texts(request: web.Request) -> PageTexts:
    """Return the texts for an error page, in the address's language or else the browser's."""
    first = request.path.removeprefix("/").partition("/")[0]
    language = first if first in all_texts() else preferred_language(request.headers.get("Accept-Language", ""))
    return all_texts()[language]
