"""The runs that a caller may see, and the episodes of a split, read page by page."""

from collections.abc import Iterator

from arramon.v1 import evaluation_pb2
from arramon_client.errors import ProtocolError
from arramon_client.transport.connection import Server, call

PAGE, MAX_PAGES = 100, 10_000
"""Number of runs per page, and maximum number of pages that are read."""


def listed_runs(server: Server) -> Iterator[evaluation_pb2.Run]:
    """Yield all runs that the caller may see, latest first.

    Raises:
        ArramonClientError: if the server refuses, or does not answer.
    """
    request = evaluation_pb2.ListRunsRequest(page_size=PAGE)
    for _ in range(MAX_PAGES):
        page = call(server.stub.ListRuns, request, server.address)
        yield from page.runs
        if not page.next_page_token:
            return
        if not page.runs or page.next_page_token == request.page_token:
            break
        request.page_token = page.next_page_token
    raise ProtocolError(f"the server has pages of runs without end: an empty or repeated one, or more than {MAX_PAGES}")


def listed_episodes(server: Server, split: str, language: str) -> Iterator[evaluation_pb2.ListedEpisode]:
    """Yield a split's episodes in a language, in playing order.

    Raises:
        ArramonClientError: if the server refuses, as for a hidden split, or does not answer.
    """
    request = evaluation_pb2.ListEpisodesRequest(split=split, language=language)
    for _ in range(MAX_PAGES):
        page = call(server.stub.ListEpisodes, request, server.address)
        yield from page.episodes
        if not page.next_page_token:
            return
        if not page.episodes or page.next_page_token == request.page_token:
            break
        request.page_token = page.next_page_token
    raise ProtocolError(f"the server has pages of episodes without end: empty or repeated, or more than {MAX_PAGES}")
