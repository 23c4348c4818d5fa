"""The pages of collections as a part of a server's web pages, found by the entry point `collecting`."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from aiohttp import web

from arramon_collecting.mail_sender import MailSender
from arramon_collecting.storage.store import Store
from arramon_collecting.verifying.text_source import StoredTexts
from arramon_collecting.verifying.text_splits import TextSplits
from arramon_collecting.web.handlers import Handlers
from arramon_collecting.web.page_group import PageGroup
from arramon_collecting.web.people.join_pages import JoinPages
from arramon_collecting.web.people.worker_pages import WorkerPages
from arramon_collecting.web.verify_groups import verify_page_groups
from arramon_collecting.web.writing.write_groups import write_page_groups
from arramon_server.episodes.splits import Split
from arramon_server.web.web_parts import WebContext

NAME = "collect"
"""First part of the names of these pages' templates and static files."""


class CollectingPart:
    """All pages of collections, and the sending of mails.

    Args:
        context: the services of the server process.

    Attributes:
        splits: the texts under verification, each as a split of one episode, by name.
    """

    def __init__(self, context: WebContext) -> None:
        context.renderer.add_folder(NAME, Path(__file__).parent)
        store = Store(context.database)
        self.splits: Mapping[str, Split] = TextSplits(context.splits, StoredTexts(store, context.splits))
        self._handlers = handlers = Handlers(store, context.renderer)
        self._pages: Sequence[PageGroup] = (
            JoinPages(handlers, context.access),
            WorkerPages(handlers, context.splits),
            *write_page_groups(context, handlers),
            *verify_page_groups(context, handlers),
        )
        self._mail = MailSender(store)
        self._mail.start()

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of all pages."""
        return [route for pages in self._pages for route in pages.routes()]

    def close(self) -> None:
        """End the threads."""
        self._mail.close()
        for pages in self._pages:
            pages.close()
        self._handlers.close()


def open_part(context: WebContext) -> CollectingPart:
    """Return the part for a server process."""
    return CollectingPart(context)
