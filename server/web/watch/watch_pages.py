"""Handlers of the pages and files on which episodes are watched: moments, frames, failures, runs being played."""

import json
import re
import time
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from aiohttp import web

from arramon_server.board.board import Board
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound, quoted
from arramon_server.playback.pictures import KINDS, SIZES, as_jpeg, draw
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.storage.corrections import voided_by
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, Run
from arramon_server.sim.cameras import CAMERAS
from arramon_server.visible_text import shown
from arramon_server.web.http_responses import HEADERS, respond
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_query import METRICS
from arramon_server.web.watch.differences_page import (
    EpisodeDifference,
    differences_context,
    episode_differences,
    read_metric,
    run_choices,
)
from arramon_server.web.watch.failures import RunFailures
from arramon_server.web.watch.failures_page import failures_context
from arramon_server.web.watch.frame_queue import ClientLeft, FrameQueue
from arramon_server.web.watch.pair_part import PairPart
from arramon_server.web.watch.playbacks import OpenPlayback, Playbacks
from arramon_server.web.watch.sign_in import COOKIE, SignIn
from arramon_server.web.watch.viewer_addresses import PROXY_HEADERS
from arramon_server.web.watch.viewers import Viewers
from arramon_server.web.watch.watch_part import WatchPart
from arramon_server.web.watch.watched_runs import WatchedEpisode, WatchedRun, WatchedRuns

FRAME_CACHE = "private, max-age=600"
"""`Cache-Control` of a frame: a recorded step never changes, but a run may be withdrawn."""

FRAME_SIZE = 448
"""Side length of a frame that is asked for without one, in pixels."""

FRESH_SECONDS = 1.0
"""Time for which an episode that was found is not looked up again for further frames."""

LISTED_RUNS = 30
"""Number of the latest runs on the page of runs to watch."""

OTHER_RUNS = 60
"""Number of runs to choose from for watching side by side."""

RUN_ID = re.compile("[0-9a-f]{32}")
"""Form of the id of a run."""

Work = Callable[[], Any]


class WatchPages:
    """Everything for watching. Only what `Viewers` and `WatchedRuns` allow is shown.

    Args:
        splits: the splits served, by name.
        journal: the journal.
        board: the leaderboard.
        viewers: derives the callers of requests.
        camera: camera of the server's runs.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        board: Board,
        viewers: Viewers,
        camera: str = CAMERAS[0],
    ) -> None:
        self._journal = journal
        self._board = board
        self._viewers = viewers
        self._runs = WatchedRuns(splits, journal, board)
        self._playbacks = Playbacks(journal, splits, camera)
        self._failures = RunFailures(splits, journal)
        self._frames = FrameQueue() if self._playbacks.draws_in_threads else FrameQueue(1)
        self._part = WatchPart(self._playbacks, journal)
        self._pairs = PairPart(self._playbacks)
        self._opened: dict[tuple[object, ...], tuple[float, OpenPlayback]] = {}
        # Replaying a whole run takes seconds, for which nothing else should wait.
        self.failures_thread = ThreadPoolExecutor(1, "failures")

    def close(self) -> None:
        """Stop drawing, and end the threads."""
        self._frames.close()
        self.failures_thread.shutdown(wait=True, cancel_futures=True)

    @property
    def can_sign_in(self) -> bool:
        """Whether participants can sign in."""
        return self._viewers.sign_in is not None

    @property
    def sign_in(self) -> SignIn:
        """Exchanges tokens for passes; only where participants can sign in."""
        assert self._viewers.sign_in is not None
        return self._viewers.sign_in

    def find(self, request: web.Request) -> Callable[[], WatchedEpisode]:
        """Return a function that finds the episode in a request's address; it raises NotFound. Call it in a thread."""
        run, episode = request.match_info["run"], request.match_info["episode"]
        return lambda: self._runs.episode(self._viewers.caller(request), run, episode)

    def context(self, t: PageTexts, request: web.Request, watched: WatchedEpisode) -> dict[str, Any]:
        """Return the template variables of the part on which an episode is watched. Call it in a thread.

        They are "watch", see `WatchPart.context`, and "others", the runs with which it can be watched side by side.
        """
        caller = self._viewers.caller(request)
        others = [] if watched.is_live else self._others(caller, watched.watched, watched.episode.episode_id)
        return {"watch": self._part.context(t, watched, request.query), "others": run_choices(t, others)}

    def pair(self, t: PageTexts, request: web.Request) -> tuple[dict[str, Any], bool]:
        """Return the template variables of an episode in two runs side by side, and whether the page is private.

        Call it in a thread.

        Raises:
            NotFound: if the caller may not watch one of them, or they are not of the same split and data.
        """
        caller, episode = self._viewers.caller(request), request.match_info["episode"]
        first = self._runs.episode(caller, request.match_info["run"], episode)
        second = self._runs.episode(caller, read_run_id(request.query), episode)
        check_comparable(first.run, second.run)
        is_private = self.is_private(request, first.watched) or self.is_private(request, second.watched)
        return {"watch": self._pairs.context(t, first, second, request.query)}, is_private

    def differences(self, t: PageTexts, request: web.Request) -> tuple[dict[str, Any], bool]:
        """Return the template variables of the episodes in which two runs differ, and whether the page is private.

        Call it in a thread.

        Raises:
            NotFound: if the caller may not watch one of the runs, or they are not of the same split and data.
        """
        caller, sort = self._viewers.caller(request), read_metric(request.query)
        watched = self._runs.run(caller, request.match_info["run"])
        others = self._others(caller, watched)
        other, found, is_private = None, list[EpisodeDifference](), self.is_private(request, watched)
        if request.query.get("with"):
            second = self._runs.run(caller, read_run_id(request.query))
            check_comparable(watched.run, second.run)
            other, is_private = second.run, is_private or self.is_private(request, second)
            found = episode_differences(
                self._journal.endings(watched.run.run_id),
                self._journal.endings(other.run_id),
                METRICS[sort],
                without=voided_by(self._board.corrections(watched.run.split)),
            )
        return differences_context(t, watched, other, others, found, sort), is_private

    def is_private(self, request: web.Request, watched: WatchedRun) -> bool:
        """Return whether a page of a run must not be kept by caches, as not everybody may see the same."""
        return watched.entry is None or watched.split.hidden or COOKIE in request.cookies

    def _others(self, caller: Caller, watched: WatchedRun, episode_id: str = "") -> list[Run]:
        return self._runs.others(caller, watched, OTHER_RUNS, episode_id)

    def moments(self, request: web.Request, t: PageTexts) -> Callable[[], web.Response]:
        """Return a function that answers a request for an episode's moments. Call it in a thread."""
        find, text = self.find(request), request.query.get("from", "0")

        def make() -> web.Response:
            if not (text.isascii() and text.isdecimal() and len(text) < 8):
                raise NotFound(f"there is no step {quoted(text)}")
            watched = find()
            content = self._part.data(t, watched, int(text))
            body = json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode()
            return respond(request, body, "application/json", cache="private, no-cache")

        return make

    async def frame(self, request: web.Request, run_in_thread: Callable[[Work], Awaitable[Any]]) -> web.Response:
        """Answer a request for the picture of a step.

        Args:
            request: the request; its query names "size" and "kind".
            run_in_thread: runs work in a thread for paths.

        Raises:
            NotFound: if there is no such episode, step, size or kind.
            Unavailable: if too many frames are asked for at once.
        """
        step = int(request.match_info["step"])
        kind, size = request.query.get("kind", KINDS[0]), request.query.get("size", str(FRAME_SIZE))
        if kind not in KINDS or size not in map(str, SIZES):
            raise NotFound(
                f"there is no picture of kind {quoted(kind)} and size {quoted(size)}; expected {', '.join(KINDS)} "
                f"and {', '.join(map(str, SIZES))}"
            )
        opened = await self._open(request, step, run_in_thread)
        try:
            state = opened.playback.moment(step).state
        except IndexError as error:
            raise NotFound(str(error)) from None

        def has_left() -> bool:
            return request.transport is None or request.transport.is_closing()

        names = request.match_info["run"], request.match_info["episode"]
        key = (*names, step, kind, size)
        try:
            jpeg = await self._frames.frame(key, lambda: as_jpeg(draw(opened.world, state, int(size), kind)), has_left)
        except ClientLeft:
            return web.Response(status=499)
        return web.Response(body=jpeg, content_type="image/jpeg", headers={**HEADERS, "Cache-Control": FRAME_CACHE})

    async def _open(
        self, request: web.Request, step: int, run_in_thread: Callable[[Work], Awaitable[Any]]
    ) -> OpenPlayback:
        """Return the playback of a request's episode, found again at most every FRESH_SECONDS."""
        # Whoever sends the same pass from the same place is the same caller.
        sender = request.remote, request.host, *map(request.headers.get, PROXY_HEADERS), request.cookies.get(COOKIE)
        key = (*sender, request.match_info["run"], request.match_info["episode"])
        kept = self._opened.get(key)
        if kept is not None and time.monotonic() < kept[0] + FRESH_SECONDS and step <= kept[1].playback.steps:
            return kept[1]
        find = self.find(request)
        opened: OpenPlayback = await run_in_thread(lambda: self._playbacks.of(find(), drawn=True))
        now = time.monotonic()
        self._opened = {name: one for name, one in self._opened.items() if now < one[0] + FRESH_SECONDS}
        self._opened[key] = now, opened
        return opened

    def failures(self, t: PageTexts, request: web.Request) -> tuple[dict[str, Any], bool]:
        """Return the template variables of the page of a run's failures, and whether the page is private.

        Call it in a thread; it may take seconds.

        Raises:
            NotFound: if the caller may not watch the run, or it has not ended.
        """
        watched = self._runs.run(self._viewers.caller(request), request.match_info["run"])
        if watched.run.state == RUNNING:
            raise NotFound(f"run {watched.run.run_id!r} has not ended")
        outcomes = self._failures.of(watched.run, watched.entry)
        return failures_context(t, watched, outcomes), self.is_private(request, watched)

    def listed(self, request: web.Request) -> Callable[[], dict[str, Any]]:
        """Return a function that returns the template variables of the page of runs to watch. Call it in a thread."""

        def make() -> dict[str, Any]:
            caller = self._viewers.caller(request)
            found = self._runs.listed(caller, LISTED_RUNS)
            progress = self._journal.progress_of([one.run.run_id for one in found])
            return {
                "may_list": caller.may_list,
                "account": shown(caller.account or ""),
                "may_sign_in": self.can_sign_in,
                "after_sign_in": self.can_sign_in and not self._viewers.lists_on_own_machine,
                "problem": "",
                "rows": [
                    (
                        one,
                        progress[one.run.run_id],
                        self._journal.open_episodes(one.run.run_id),
                        [ending.episode_id for ending in self._journal.endings(one.run.run_id)[-3:]],
                    )
                    for one in found
                ],
            }

        return make


def read_run_id(query: Mapping[str, str]) -> str:
    """Return the id of the other run in the query of an address.

    Raises:
        NotFound: if it is no id of a run.
    """
    run_id = query.get("with", "")
    if not RUN_ID.fullmatch(run_id):
        raise NotFound(f"there is no run {quoted(run_id)} to watch")
    return run_id


def check_comparable(first: Run, second: Run) -> None:
    """Check that two runs are of the same episodes.

    Raises:
        NotFound: if they are one run, or of different splits.
    """
    if first.run_id == second.run_id or first.split != second.split:
        raise NotFound(f"run {first.run_id!r} cannot be compared with {second.run_id!r}, expected another of its split")
