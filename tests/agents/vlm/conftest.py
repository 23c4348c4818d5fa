"""Fixtures: a key in the environment, short pauses, and an agent that asks a fake endpoint."""

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("openai", reason="the extra `vlm` is not installed: scripts/setup")

from arramon_agents.vlm import endpoint as endpoint_module
from arramon_agents.vlm import make_agent
from arramon_agents.vlm.agent import VlmAgent
from benchmarks.agents.fake_endpoint import FakeEndpoint
from tests.agents.vlm import helpers


@pytest.fixture(autouse=True)
def _key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", helpers.KEY)
    monkeypatch.setattr(endpoint_module, "FIRST_PAUSE", 0.001)
    monkeypatch.setattr(endpoint_module, "SHORTEST_WAIT", 0.001)


@pytest.fixture
def fake() -> Iterator[FakeEndpoint]:
    with FakeEndpoint(helpers.always("forward")) as endpoint:
        yield endpoint


MakeAgent = Callable[..., VlmAgent]


@pytest.fixture
def made(fake: FakeEndpoint, tmp_path: Path) -> MakeAgent:
    """Makes an agent that asks the fake endpoint, without a sight check unless one is asked for."""

    def make(**given: Any) -> VlmAgent:
        chosen = {"model": "m", "endpoint": fake.url, "trace": str(tmp_path), "sight": "skip", "attempts": 3, **given}
        return make_agent(**chosen)

    return make


@pytest.fixture
def run() -> Callable[[Coroutine[Any, Any, Any]], Any]:
    return asyncio.run
