"""Playback for hosts: the walk of a verification, or the described way of a text, as the pages for watching show it."""

import asyncio
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from aiohttp import web

from arramon_collecting.verifying.text_splits import split_name
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound, quoted
from arramon_server.playback.pictures import KINDS, SIZES, as_jpeg, draw
from arramon_server.runs.results.reports import split_as_played
from arramon_server.runs.run_service import HUMAN
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import COMPLETE, Run
from arramon_server.sim.rules import Limits
from arramon_server.web.http_responses import HEADERS
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.watch.frame_queue import ClientLeft, FrameQueue
from arramon_server.web.watch.playbacks import Playbacks
from arramon_server.web.watch.watch_pages import FRAME_SIZE
from arramon_server.web.watch.watch_part import WatchPart
from arramon_server.web.watch.watched_runs import WatchedEpisode, WatchedRun

T = TypeVar("T")


class WalkActions:
    """Actions of runs from the journal, and those of described ways (`web.watch.playbacks.ActionSource`).

    Args:
        splits: all splits by name, those of texts included.
        journal: the journal.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal) -> None:
        self._splits = splits
        self._journal = journal

    def actions(self, run_id: str, episode_id: str, first: int = 0) -> Sequence[int]:
        """Return the actions of a run's episode from step `first` on.

        The id of a described way is the name of its text's split.
        """
        split = self._splits.get(run_id) if "/" in run_id else None
        if split is None:
            return self._journal.actions(run_id, episode_id, first)
        turns = split.episodes[episode_id].turns
        return [int(action) for turn in turns for action in (*turn.actions, *turn.room_actions)][first:]


class WalkPlayback:
    """Plays back walks. Only hosts may be shown any.

    Args:
        splits: all splits by name, those of texts included.
        journal: the journal.
        camera: camera of the server's runs.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal, camera: str) -> None:
        self._splits = splits
        self._journal = journal
        self._playbacks = Playbacks(WalkActions(splits, journal), splits, camera)
        self._part = WatchPart(self._playbacks, journal)
        self._frames = FrameQueue() if self._playbacks.draws_in_threads else FrameQueue(1)
        self._thread = ThreadPoolExecutor(1, "walks")

    def close(self) -> None:
        """Stop drawing, and end the threads."""
        self._frames.close()
        self._thread.shutdown(wait=True, cancel_futures=True)

    def walk(self, run_id: str) -> WatchedEpisode:
        """Return the walk of a verification's run.

        Raises:
            NotFound: if there is no such run.
            Conflict: if its text has changed since.
        """
        run = self._journal.run(run_id)
        split = split_as_played(run, self._splits)
        (episode,) = split.episodes.values()
        state = self._journal.episode_state(run_id, episode.episode_id)
        return WatchedEpisode(WatchedRun(run, split, None, is_own=True), episode, state[1] if state else None)

    def described_way(self, collection: str, text_id: str) -> WatchedEpisode:
        """Return the way that a text describes, as if somebody had walked it.

        Raises:
            NotFound: if the text's episode is not served.
        """
        name = split_name(collection, text_id)
        split = self._splits.get(name)
        if split is None:
            raise NotFound(f"there is no text {quoted(text_id)} whose episode this server has")
        (episode,) = split.episodes.values()
        (language,) = episode.instructions
        run = Run(
            run_id=name,
            participant="",
            agent=HUMAN,
            split=name,
            language=language,
            sensors=("rgb",),
            steps_per_phase=Limits().steps_per_phase,
            data_hash=split.data_hash,
            server_version="",
            state=COMPLETE,
            created_at=self._journal.time(),
        )
        return WatchedEpisode(WatchedRun(run, split, None, is_own=True), episode, None)

    async def context(
        self, t: PageTexts, watched: WatchedEpisode, query: Mapping[str, str], here: str
    ) -> dict[str, Any]:
        """Return the template variables of the player.

        Args:
            t: texts of the page's language.
            watched: the walk.
            query: query of the address: "step".
            here: the page's address; those of moments and frames begin with it.

        Raises:
            NotFound: if there is no such step.
        """
        found = await self._in_thread(lambda: self._part.context(t, watched, query))
        return found | {"here": here, "files": here, "frame": f"{here}/frames/{found['now']['step']}.jpg"}

    async def moments(self, t: PageTexts, watched: WatchedEpisode, first: str) -> web.Response:
        """Return the moments from a step on, as the scripts read them.

        Raises:
            NotFound: if there is no such step.
        """
        if not (first.isascii() and first.isdecimal() and len(first) < 8):
            raise NotFound(f"there is no step {quoted(first)}")
        content = await self._in_thread(lambda: self._part.data(t, watched, int(first)))
        body = json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode()
        headers = {**HEADERS, "Cache-Control": "no-store"}
        return web.Response(body=body, content_type="application/json", charset="utf-8", headers=headers)

    async def frame(self, request: web.Request, watched: WatchedEpisode, step: int) -> web.Response:
        """Return the picture of a step; the request's query names "size" and "kind".

        Raises:
            NotFound: if there is no such step, size or kind.
            Unavailable: if too many frames are asked for at once.
        """
        kind, size = request.query.get("kind", KINDS[0]), request.query.get("size", str(FRAME_SIZE))
        if kind not in KINDS or size not in map(str, SIZES):
            raise NotFound(f"there is no picture of kind {quoted(kind)} and size {quoted(size)}")
        opened = await self._in_thread(lambda: self._playbacks.of(watched, drawn=True))
        try:
            state = opened.playback.moment(step).state
        except IndexError as error:
            raise NotFound(str(error)) from None

        def has_left() -> bool:
            return request.transport is None or request.transport.is_closing()

        key = (watched.run.run_id, watched.episode.episode_id, step, kind, size)
        try:
            jpeg = await self._frames.frame(key, lambda: as_jpeg(draw(opened.world, state, int(size), kind)), has_left)
        except ClientLeft:
            return web.Response(status=499)
        headers = {**HEADERS, "Cache-Control": "private, no-store"}
        return web.Response(body=jpeg, content_type="image/jpeg", headers=headers)

    async def _in_thread(self, work: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, work)
