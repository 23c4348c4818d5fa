"""ListEpisodes: a split's episodes in playing order, page by page; those of a hidden split are not listed."""

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.serving import METADATA


def listed(stub: EvaluationStub, language: str, page_size: int) -> list[str]:
    """Return the ids of all pages."""
    ids: list[str] = []
    request = pb.ListEpisodesRequest(split="tiny", language=language, page_size=page_size)
    while True:
        page = stub.ListEpisodes(request, metadata=METADATA)
        assert {episode.section for episode in page.episodes} == {"1"}
        assert len(page.episodes) <= (page_size or 1000)
        ids += [episode.episode_id for episode in page.episodes]
        if not page.next_page_token:
            return ids
        request.page_token = page.next_page_token


def test_pages_list_the_episodes_in_playing_order(stub: EvaluationStub) -> None:
    ids = listed(stub, "en", 0)
    assert listed(stub, "en", 1) == listed(stub, "en", 2) == ids
    assert len(set(ids)) == len(ids) > len(listed(stub, "hi", 3)) > 0
    run = create(stub, episodes=2)
    with Player(stub, run.run_id, episodes=2) as player:
        assert [player.observation().episode_id for _ in range(2)] == ids[:2]


@pytest.mark.parametrize(
    ("fields", "code", "message"),
    [
        (
            {"split": "secret"},
            "INVALID_ARGUMENT",
            "split 'secret' is hidden and can only be played whole; its episodes are not listed",
        ),
        ({"split": "none"}, "NOT_FOUND", "there is no split 'none'; this server has secret, tiny"),
        ({"language": "xx"}, "NOT_FOUND", "split 'tiny' has no episodes in 'xx'; it has en, hi"),
        ({"page_size": 10_001}, "INVALID_ARGUMENT", "page_size is 10001, expected 1 to 10000"),
        (
            {"page_token": "x"},
            "INVALID_ARGUMENT",
            "page_token is 'x', expected the next_page_token of the previous page",
        ),
    ],
)
def test_what_is_not_listed(stub: EvaluationStub, fields: dict[str, str], code: str, message: str) -> None:
    request = pb.ListEpisodesRequest(**{"split": "tiny", "language": "en", **fields})  # type: ignore[arg-type]
    assert refused(lambda: stub.ListEpisodes(request, metadata=METADATA)) == (grpc.StatusCode[code], message)
