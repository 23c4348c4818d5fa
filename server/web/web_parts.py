"""Parts of the web pages that installed packages add, found by entry points, and what a server process lends them."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from typing import Protocol

from aiohttp import web

from arramon_server.configuration.config import Config
from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.episodes.splits import Split
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.web.host import Host
from arramon_server.web.play.browser_access import BrowserAccess
from arramon_server.web.rendering import Renderer

ENTRY_POINTS = "arramon.web"
"""Entry-point group: the part's name, and a module whose function `open_part` takes a `WebContext` and returns a
`WebPart`."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class WebContext:
    """The services of a server process that a part of its pages may use.

    Attributes:
        config: the server's settings.
        database: the journal's database.
        splits: the served splits by name; parts may add further ones, see `SplitLookup.add`.
        journal: storage of the runs.
        runs: creates and finds runs.
        engine: plays runs.
        threads: in which frames are compressed.
        renderer: renders templates; a part adds its own folder of them, see `Renderer.add_folder`.
        access: authenticates people by token, and limits streams.
        host: the host of the leaderboard.
    """

    config: Config
    database: Database
    splits: SplitLookup
    journal: Journal
    runs: RunService
    engine: Engine
    threads: ImageThreads
    renderer: Renderer
    access: BrowserAccess
    host: Host


class WebPart(Protocol):
    """One part of the pages.

    Attributes:
        splits: further splits by name, played but not listed; `KeyError` for unknown names.
    """

    splits: Mapping[str, Split]

    def routes(self) -> list[web.RouteDef]:
        """Return the part's routes, which precede those of the leaderboard."""
        ...

    def close(self) -> None:
        """Stop accepting work, and end the part's threads."""
        ...


def open_parts(context: WebContext) -> list[WebPart]:
    """Open the parts of all installed packages, and add their splits to those of the context.

    A part that needs a package which is not installed is left out, with a warning in the log.
    """
    parts: list[WebPart] = []
    for entry in sorted(entry_points(group=ENTRY_POINTS), key=lambda entry: entry.name):
        try:
            module = import_module(entry.module)
        except ModuleNotFoundError as missing:
            _log.warning("the pages %r are left out: %s", entry.name, missing)
            continue
        part: WebPart = module.open_part(context)
        context.splits.add(part.splits)
        parts.append(part)
    return parts
