"""The groups of pages of verifying and review, connected with each other."""

from arramon_collecting.review.walk_playback import WalkPlayback
from arramon_collecting.verifying.walk_results import WalkResults
from arramon_collecting.web.handlers import Handlers
from arramon_collecting.web.page_group import PageGroup
from arramon_collecting.web.people.device_page import DevicePage
from arramon_collecting.web.people.screening_pages import ScreeningPages
from arramon_collecting.web.people.task_claims import TaskClaims
from arramon_collecting.web.review.host_pages import HostPages
from arramon_collecting.web.review.review_pages import ReviewPages
from arramon_collecting.web.review.walk_pages import WalkPages
from arramon_collecting.web.verifying.placement_page import PlacementPage
from arramon_collecting.web.verifying.verify_pages import VerifyPages
from arramon_collecting.web.verifying.verify_socket import VerifySockets
from arramon_server.web.web_parts import WebContext


def verify_page_groups(context: WebContext, handlers: Handlers) -> list[PageGroup]:
    """Return the groups of pages.

    Args:
        context: the services of the server process.
        handlers: what all pages of collections share.
    """
    sockets = VerifySockets(context, handlers.store)
    results = WalkResults(context.splits, context.journal)
    playback = WalkPlayback(context.splits, context.journal, context.config.camera)
    return [
        DevicePage(handlers),
        ScreeningPages(handlers, TaskClaims(handlers.store, context.splits)),
        PlacementPage(handlers, sockets),
        VerifyPages(handlers, sockets, context.journal, results),
        ReviewPages(handlers, context.splits),
        WalkPages(handlers, playback),
        HostPages(handlers),
    ]
