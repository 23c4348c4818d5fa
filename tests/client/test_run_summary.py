"""An agent's line on what it has used."""

from typing import Any

import pytest

from arramon_client.errors import AgentError
from arramon_client.plugin import agent_calls


class Using:
    def __init__(self, said: Any) -> None:
        self.said = said

    def run_summary(self) -> Any:
        if isinstance(self.said, Exception):
            raise self.said
        return self.said


@pytest.mark.parametrize(
    ("agent", "line"), [(Using("2 calls,\n  5 tokens"), "2 calls, 5 tokens"), (Using(""), ""), (object(), "")]
)
def test_summary(agent: object, line: str) -> None:
    assert agent_calls.summary(agent) == line


@pytest.mark.parametrize(
    ("said", "message"),
    [(ValueError("no"), r"run_summary\(\) raised ValueError: no"), (None, r"run_summary\(\) returned None; expected")],
)
def test_wrong_summaries(said: Any, message: str) -> None:
    with pytest.raises(AgentError, match=message):
        agent_calls.summary(Using(said))
