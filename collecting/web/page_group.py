"""A group of pages."""

from typing import Protocol

from aiohttp import web


class PageGroup(Protocol):
    """Some of the pages."""

    def routes(self) -> list[web.RouteDef]:
        """Return their routes."""
        ...

    def close(self) -> None:
        """End what they have begun."""
        ...
