"""Database queries of ListRuns: their number does not depend on the number of runs listed."""

import asyncio
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import grpc
import pytest
import sqlalchemy as sa

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.configuration.config import Config
from arramon_server.process.server_parts import create_parts
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.serving import METADATA


@pytest.fixture
def questions() -> Iterator[list[str]]:
    """What databases of this process are asked, as it comes."""
    queries: list[str] = []

    def note(*of: object) -> None:
        queries.extend([str(of[2])] if str(of[2]).startswith("SELECT") else [])

    sa.event.listen(sa.Engine, "before_cursor_execute", note)
    yield queries
    sa.event.remove(sa.Engine, "before_cursor_execute", note)


def test_page_size_does_not_change_the_number_of_queries(tmp_path: Path, questions: list[str]) -> None:
    config = Config(data=tmp_path, listen="127.0.0.1:0")
    splits = {"tiny": tiny.write(tmp_path)}

    async def costs(database: Database) -> list[int]:
        parts = create_parts(config, splits, database)
        await parts.server.start()
        try:
            async with grpc.aio.insecure_channel(parts.address) as channel:
                stub: Any = EvaluationStub(channel)
                for _ in range(30):
                    request = pb.CreateRunRequest(agent="a", split="tiny", language="en")
                    last = await stub.CreateRun(request, metadata=METADATA)
                counted = []
                for size in (1, 20):
                    questions.clear()
                    listing = pb.ListRunsRequest(page_size=size, page_token=last.run_id)
                    page = await stub.ListRuns(listing, metadata=METADATA)
                    assert [run.episodes for run in page.runs] == [6] * size
                    counted.append(len(questions))
                return counted
        finally:
            await parts.server.stop(None)

    with closing(Database(config.journal_url)) as database:
        one, many = asyncio.run(costs(database))
    assert one == many == 6
