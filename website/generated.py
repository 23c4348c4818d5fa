"""The pages of the site that are made from the code."""

from collections.abc import Sequence

from website.machine import files
from website.page import Page
from website.reference import api, commands, protocol

__all__ = ["Page", "generated_pages"]


def generated_pages() -> Sequence[Page]:
    """Return all generated pages, in the order of the navigation."""
    return (*api.pages(), *commands.pages(), *protocol.pages(), *files.pages())
