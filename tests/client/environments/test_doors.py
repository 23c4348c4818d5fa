"""All doors agree: the same actions give the same observations, scores and hash chain."""

import random
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from tests import tiny
from tests.client.environments.doors import DOORS, STEPS, Door, Played, over_grpc
from tests.serving import Server

WANDERING = [random.Random(7).choice((0, 0, 0, 1, 2, 2, 3)) for _ in range(4 * STEPS)]
"""Ends some phases by itself, others at the step limit."""

PLAYED = {"truth": tiny.ACTIONS, "wandering": WANDERING, "standing": [1]}


@pytest.fixture(scope="module")
def server(data: Path) -> Iterator[Server]:
    server = Server(data, "127.0.0.1:0", "--steps", str(STEPS))
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module", params=[(name, language) for name in PLAYED for language in ("en", "hi")])
def reference(request: pytest.FixtureRequest, data: Path, server: Server) -> tuple[str, Sequence[int], Played]:
    name, language = request.param
    actions = [int(action) for action in PLAYED[name]]
    return language, actions, over_grpc(server, language, actions)


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.__name__)
def test_a_door_agrees_with_the_stream(
    door: Door, reference: tuple[str, Sequence[int], Played], data: Path, server: Server
) -> None:
    language, actions, there = reference
    here = door(data, server, language, actions, there.run_id)
    assert len(here.seen) == len(there.seen)
    for step, (one, other) in enumerate(zip(here.seen, there.seen, strict=True)):
        assert one == other, f"step {step}"
    assert (here.cause, here.scores, here.head) == (there.cause, there.scores, there.head)
