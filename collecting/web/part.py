"""The pages of collections as a part of a server's web pages, found by the entry point `collecting`."""

from collections.abc import Mapping
from pathlib import Path

from aiohttp import web

from arramon_collecting.storage.store import Store
from arramon_collecting.web.handlers import Handlers
from arramon_collecting.web.writing.screening_page import WriteScreening
from arramon_collecting.web.writing.write_page import NAME as WRITING
from arramon_collecting.web.writing.write_page import WritePage
from arramon_collecting.web.writing.write_tasks import WriteTasks
from arramon_collecting.writing.pictures import WriterPictures
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
        context.renderer.add_folder(WRITING, Path(__file__).parent / "writing")
        store = Store(context.database)
        self._handlers = Handlers(store, context.renderer)
        self._writing = WritePage(
            self._handlers,
            WriteTasks(store, context.splits),
            WriterPictures(context.splits, context.config.camera),
            context.config.play_image_sizes[0],
        )
        self._screening = WriteScreening(self._handlers)

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of all pages."""
        return [*self._writing.routes(), *self._screening.routes()]

    def close(self) -> None:
        """End the threads."""
        self._writing.close()
        self._handlers.close()


def open_part(context: WebContext) -> CollectingPart:
    """Return the part for a server process."""
    return CollectingPart(context)
