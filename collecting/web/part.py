"""The pages of collections as a part of a server's web pages, found by the entry point `collecting`."""

from collections.abc import Mapping
from pathlib import Path

from aiohttp import web

from arramon_collecting.storage.store import Store
from arramon_collecting.web.handlers import Handlers
from arramon_server.episodes.splits import Split
from arramon_server.web.web_parts import WebContext

NAME = "collect"
"""First part of the names of these pages' templates and static files."""


class CollectingPart:
    """All pages of collections.

    Args:
        context: the services of the server process.

    Attributes:
        splits: the texts under verification, each as a split of one episode, by name.
    """

    def __init__(self, context: WebContext) -> None:
        context.renderer.add_folder(NAME, Path(__file__).parent)
        self.splits: Mapping[str, Split] = {}
        self._handlers = Handlers(Store(context.database), context.renderer)

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of all pages."""
        return []

    def close(self) -> None:
        """End the threads."""
        self._handlers.close()


def open_part(context: WebContext) -> CollectingPart:
    """Return the part for a server process."""
    return CollectingPart(context)
