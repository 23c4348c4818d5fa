"""A server and a stub for each test."""

from collections.abc import Iterator

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.transport.connection import Server, connect
from tests.client.fake import Servicer, World, serving


@pytest.fixture
def world() -> World:
    return World()


@pytest.fixture
def server(world: World) -> Iterator[Server]:
    with serving(Servicer(world)) as address, connect(address) as connected:
        yield connected


@pytest.fixture
def run(world: World) -> pb.Run:
    return world.create(pb.CreateRunRequest(agent="recorder", split="val_seen", language="en"))
