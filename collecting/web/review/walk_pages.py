"""Playback for hosts: the walk of a verification, or the way that a text describes."""

from aiohttp import web

from arramon_collecting.review.walk_playback import WalkPlayback
from arramon_collecting.storage.records import Collection
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import Handlers, request_texts
from arramon_collecting.web.review.host_view import collection_address, common
from arramon_collecting.web.review.review_pages import TEXT
from arramon_server.errors import NotFound
from arramon_server.web.watch.watched_runs import WatchedEpisode

DESCRIBED = "described"
"""Name of the described way among the walks of a text."""

WALK = f"{TEXT}/walks/{{walk:[0-9a-f]{{32}}|{DESCRIBED}}}"


class WalkPages:
    """The pages and their files, for hosts only.

    Args:
        handlers: what all pages of collections share.
        playback: plays back walks.
    """

    def __init__(self, handlers: Handlers, playback: WalkPlayback) -> None:
        self._handlers = handlers
        self._playback = playback

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [
            web.get(WALK, guarded(self._show)),
            web.get(f"{WALK}/moments.json", guarded(self._moments)),
            web.get(f"{WALK}/frames/{{step:[0-9]{{1,7}}}}.jpg", guarded(self._frame)),
        ]

    def close(self) -> None:
        """Stop drawing."""
        self._playback.close()

    async def _show(self, request: web.Request) -> web.StreamResponse:
        collection, visitor, watched = await self._handlers.run(lambda: self._find(request))
        t, walk = request_texts(request), request.match_info["walk"]
        player = await self._playback.context(t, watched, request.query, request.path)

        def make() -> web.Response:
            text = self._handlers.store.texts.get(request.match_info["text"])
            about = t("collect_walk.about_described")
            if walk != DESCRIBED:
                verifier = self._handlers.store.verifications.get(walk).worker_id
                about = t("collect_walk.about_walk", worker=verifier[:8])
            context = common(request, "") | {
                "watch": player,
                "episode_id": text.episode_id,
                "text_address": f"{collection_address(request)}/review/{text.text_id}",
                "about": about,
            }
            return self._handlers.page(request, "collect/walk.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _moments(self, request: web.Request) -> web.StreamResponse:
        _, _, watched = await self._handlers.run(lambda: self._find(request))
        return await self._playback.moments(request_texts(request), watched, request.query.get("from", "0"))

    async def _frame(self, request: web.Request) -> web.StreamResponse:
        _, _, watched = await self._handlers.run(lambda: self._find(request))
        return await self._playback.frame(request, watched, int(request.match_info["step"]))

    def _find(self, request: web.Request) -> tuple[Collection, Visitor, WatchedEpisode]:
        collection, visitor = self._handlers.visitor(request, host=True)
        text_id, walk = request.match_info["text"], request.match_info["walk"]
        text = self._handlers.store.texts.get(text_id)
        if text.collection != collection.name:
            raise NotFound("there is no such text in this collection")
        if walk == DESCRIBED:
            return collection, visitor, self._playback.described_way(collection.name, text_id)
        verification = self._handlers.store.verifications.get(walk)
        if verification.text_id != text_id:
            raise NotFound("there is no such verification of this text")
        return collection, visitor, self._playback.walk(verification.run_id)
