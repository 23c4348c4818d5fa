"""The runs that a caller may see, and the episodes of a split, read page by page."""

from collections.abc import Iterator, Sequence

from arramon.v1 import evaluation_pb2
from arramon_client.transport.connection import Server, call
from arramon_client.transport.pages import read_pages

PAGE, MAX_PAGES = 100, 10_000
"""Number of runs per page, and maximum number of pages that are read."""


def listed_runs(server: Server) -> Iterator[evaluation_pb2.Run]:
    """Yield all runs that the caller may see, latest first.

    Raises:
        ArramonClientError: if the server refuses, or does not answer.
    """

    def read(token: str) -> tuple[Sequence[evaluation_pb2.Run], str]:
        request = evaluation_pb2.ListRunsRequest(page_size=PAGE, page_token=token)
        page = call(server.stub.ListRuns, request, server.address)
        return page.runs, page.next_page_token

    return read_pages(read, "runs", MAX_PAGES)


def listed_episodes(server: Server, split: str, language: str) -> Iterator[evaluation_pb2.ListedEpisode]:
    """Yield a split's episodes in a language, in playing order.

    Raises:
        ArramonClientError: if the server refuses, as for a hidden split, or does not answer.
    """

    def read(token: str) -> tuple[Sequence[evaluation_pb2.ListedEpisode], str]:
        request = evaluation_pb2.ListEpisodesRequest(split=split, language=language, page_token=token)
        page = call(server.stub.ListEpisodes, request, server.address)
        return page.episodes, page.next_page_token

    return read_pages(read, "episodes", MAX_PAGES)
