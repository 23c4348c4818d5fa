"""The play page, `/LANGUAGE/play`, and the address of its WebSocket."""

import json
from typing import Any

from aiohttp import web

from arramon_server.board.publisher import Publisher
from arramon_server.configuration.config import Config
from arramon_server.episodes.splits import Split
from arramon_server.errors import Forbidden
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.journal import Journal
from arramon_server.web.http_responses import HEADERS
from arramon_server.web.named_things import first_name
from arramon_server.web.page_texts import PageTexts, all_texts
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.browser_access import BrowserAccess, check_origin
from arramon_server.web.play.people_runs import PeopleRuns
from arramon_server.web.play.play_ground import PlayGround, Practice
from arramon_server.web.play.play_socket import PlaySocket
from arramon_server.web.play.played_scores import PlayedScores
from arramon_server.web.play.requests import MAX_EPISODES, MAX_REQUEST_BYTES
from arramon_server.web.play.thing_pictures import ThingPictures, pictured_things
from arramon_server.web.rendering import Renderer

SOCKET = "/play/socket"
"""Address of the WebSocket."""

PICTURES = "/play/pictures"
"""Address of the folder of pictures of things."""

SOCKET_SHARE = 4
"""Divisor of the process's limit of calls: play pages may have 1/SOCKET_SHARE of it open."""


class PlayPage:
    """The play page and its WebSockets.

    Args:
        config: the server's settings.
        access: authenticates people, and limits streams.
        runs: creates and finds runs.
        journal: storage of the runs.
        publisher: publishes runs.
        engine: plays them.
        threads: in which frames are compressed.
        renderer: renders the parts of the page that show scores.
    """

    def __init__(
        self,
        config: Config,
        access: BrowserAccess,
        runs: RunService,
        journal: Journal,
        publisher: Publisher,
        engine: Engine,
        threads: ImageThreads,
        renderer: Renderer,
    ) -> None:
        self._access = access
        aids = Aids.of_config(config)
        self._ground = PlayGround(
            PeopleRuns(runs, journal, publisher, aids),
            PlayedScores(runs, journal, runs.splits, renderer),
            engine,
        )
        self._practice = Practice(config.camera, threads, renderer, aids)
        self._threads = threads
        self._sizes = config.play_image_sizes
        self._keepalive_seconds = config.keepalive_seconds
        self._max_sockets = max(1, config.max_calls // SOCKET_SHARE)
        self._pictures = ThingPictures(config.camera)
        self._open = 0

    def close(self) -> None:
        """End the tutorial, and the thread that draws scores."""
        self._ground.scores.close()
        self._practice.close()

    def context(self, t: PageTexts) -> dict[str, Any]:
        """Return the template variables of the page in a language."""
        return {
            "splits": [_choice(t, split) for split in self._playable(t.language)],
            "needs_token": self._access.needs_token,
            "max_episodes": MAX_EPISODES,
            "pictures": PICTURES,
            "things": [(thing, names_of(thing)) for thing in pictured_things()],
            "settings": {
                "socket": SOCKET,
                "language": t.language,
                "sizes": [self._sizes[0], self._sizes[-1]],
                "texts": {
                    key.removeprefix("play_js."): text for key, text in t.words.items() if key.startswith("play_js.")
                },
            },
        }

    def _playable(self, language: str) -> list[Split]:
        """Return the splits with instructions in a language, those for training last."""
        found = [
            split for split in self._ground.runs.splits.values() if language in split.languages and not split.training
        ]
        return sorted(found, key=lambda split: (split.hidden, split.name))

    def picture(self, thing: str) -> bytes:
        """Return the picture of a thing that instructions name, in JPEG. Thread-safe.

        Raises:
            NotFound: if there is none.
        """
        return self._pictures.jpeg(thing)

    async def serve_socket(self, request: web.Request) -> web.StreamResponse:
        """Serve a WebSocket of the play page until it is closed."""
        try:
            check_origin(request)
        except Forbidden as error:
            return _refused(403, str(error))
        if self._open >= self._max_sockets:
            return _refused(503, f"too many people play at this server process: {self._max_sockets} are allowed")
        socket = web.WebSocketResponse(
            heartbeat=self._keepalive_seconds, max_msg_size=2 * MAX_REQUEST_BYTES, compress=False
        )
        if not socket.can_prepare(request).ok:
            return _refused(400, "this address is for the WebSocket of the play page")
        self._open += 1
        try:
            await socket.prepare(request)
            sizes = (self._sizes[0], self._sizes[-1])
            await PlaySocket(socket, request, self._access, self._ground, self._practice, self._threads, sizes).serve()
        finally:
            self._open -= 1
        return socket


def _choice(t: PageTexts, split: Split) -> dict[str, Any]:
    return {"name": split.name, "hidden": split.hidden, "episodes": split.languages[t.language]}


def names_of(thing: str) -> list[tuple[str, str]]:
    """Return the name of one of `pictured_things` in each language of the pages, after the language's code."""
    kind, _, look = thing.partition("_") if thing.startswith(("building_", "wall_")) else (thing, "", "")
    return [(code, first_name(t, kind, look)) for code, t in all_texts().items()]


def _refused(status: int, reason: str) -> web.Response:
    body = json.dumps({"error": reason}).encode()
    return web.Response(status=status, body=body, headers=HEADERS, content_type="application/json")
