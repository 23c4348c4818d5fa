"""Arguments are checked before anything is created, and what may change the play is recorded."""

from pathlib import Path
from typing import Any

import openai
import pytest

from arramon_agents.vlm import make_agent
from arramon_client.errors import AgentLoadError
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent

WRONG: list[tuple[dict[str, Any], str]] = [
    ({"plan": 0}, "plan is '0'; expected a whole number from 1 to 50"),
    ({"plan": 2.5}, "plan is '2.5'; expected a whole number"),
    ({"plan": True}, "plan is 'True'; expected a whole number"),
    ({"window": -1}, "window is '-1'; expected a whole number from 0 to 100"),
    ({"temperature": "hot"}, "temperature is 'hot'; expected a number from 0 to 2"),
    ({"answers": "xml"}, "answers is 'xml'; expected one of schema, object, plain, tools"),
    ({"image_format": "gif"}, "image_format is 'gif'; expected one of png, jpeg"),
    ({"sight": False}, "sight is 'False'; expected one of check, mark, skip"),
    ({"images": "no"}, "images is 'no'; expected true or false"),
    ({"extra": "x"}, "extra is 'x'; expected a JSON object"),
    ({"model": ""}, "model is ''; expected a text"),
    ({"model": 4}, "model is '4'; expected a text"),
    ({"max_cost": 1.0}, "max_cost needs prices=FILE"),
    ({"endpoint": "localhost:8000"}, "expected a URL such as http://localhost:8000/v1"),
    ({"endpoint": "http://[::1"}, "expected a URL such as http://localhost:8000/v1"),
    ({"endpoint": "https://me:secret@host/v1"}, "endpoint must hold neither a password nor a query"),
    ({"endpoint": "https://host/v1?api-key=secret"}, "endpoint must hold neither a password nor a query"),
    ({"key_variable": "NOT_SET_KEY"}, "no key in the environment variable NOT_SET_KEY"),
    ({"prompts": "/nowhere.toml"}, "prompts /nowhere.toml cannot be read: No such file"),
    ({"prices": "/nowhere.toml"}, "prices /nowhere.toml cannot be read: No such file"),
    ({"trace": "/dev/null/x"}, "trace=/dev/null/x cannot be created: Not a directory"),
]


@pytest.mark.parametrize(("given", "message"), WRONG)
def test_wrong_arguments(given: dict[str, Any], message: str, made: MakeAgent) -> None:
    with pytest.raises(AgentLoadError) as caught:
        made(**given)
    assert message in str(caught.value)
    assert "secret" not in str(caught.value)


def test_a_key_is_needed_for_openai_and_a_named_variable_only(
    monkeypatch: pytest.MonkeyPatch, made: MakeAgent, tmp_path: Path
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY")
    made()  # an endpoint of one's own
    with pytest.raises(AgentLoadError, match="no key in the environment variable OPENAI_API_KEY"):
        make_agent(model="m", trace=str(tmp_path))
    monkeypatch.setenv("OPENAI_API_KEY", "two words")
    with pytest.raises(AgentLoadError, match="does not hold a key") as caught:
        make_agent(model="m", trace=str(tmp_path))
    assert "two words" not in str(caught.value)


def test_the_run_records_what_may_change_the_play(made: MakeAgent) -> None:
    """Neither limits nor paths nor the key: a run may be resumed with others."""
    agent = made(plan=2, seed=7, extra={"top_p": 0.5}, max_calls=9, concurrency=3, temperature=0)
    recorded = dict(agent.recorded_arguments)
    assert recorded.pop("endpoint").startswith("http://127.0.0.1:")
    assert len(recorded.pop("prompts")) == 12
    assert recorded == {
        "model": "m", "plan": "2", "temperature": "0", "seed": "7", "extra": '{"top_p":0.5}', "sight": "skip",
        "openai": openai.__version__,
    }  # fmt: skip
    assert made().recorded_arguments["seed"] == "none"
    assert helpers.KEY not in repr(agent.recorded_arguments)
