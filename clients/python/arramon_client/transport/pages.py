"""Reading of answers that a server sends page by page."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from arramon_client.errors import ProtocolError

Item = TypeVar("Item")


def read_pages(read: Callable[[str], tuple[Sequence[Item], str]], what: str, most: int) -> Iterator[Item]:
    """Yield the items of all pages, in order.

    Args:
        read: returns the items of the page with a token, and the next page's token, which is empty on the last page;
            the first page's token is empty.
        what: the items, for the error.
        most: maximum number of pages that are read.

    Raises:
        ProtocolError: if the pages do not end: one before the last is empty, repeats its token, or there are too many.
    """
    token = ""
    for _ in range(most):
        items, following = read(token)
        yield from items
        if not following:
            return
        if not items or following == token:
            break
        token = following
    raise ProtocolError(f"the server has pages of {what} without end: an empty or repeated one, or more than {most}")
