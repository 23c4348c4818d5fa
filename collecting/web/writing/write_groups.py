"""The groups of pages of writing."""

from pathlib import Path

from arramon_collecting.web.handlers import Handlers
from arramon_collecting.web.page_group import PageGroup
from arramon_collecting.web.writing.write_page import NAME, WritePage
from arramon_collecting.web.writing.write_tasks import WriteTasks
from arramon_collecting.writing.pictures import WriterPictures
from arramon_server.web.web_parts import WebContext


def write_page_groups(context: WebContext, handlers: Handlers) -> list[PageGroup]:
    """Return the groups of pages.

    Args:
        context: the services of the server process.
        handlers: what all pages of collections share.
    """
    context.renderer.add_folder(NAME, Path(__file__).parent)
    pictures = WriterPictures(context.splits, context.config.camera)
    tasks = WriteTasks(handlers.store, context.splits)
    return [WritePage(handlers, tasks, pictures, context.config.play_image_sizes[0])]
