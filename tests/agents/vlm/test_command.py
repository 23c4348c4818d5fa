"""The real client with the agent: results, notes, signature, limits, and a key that is in no file."""

import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import openai
import pytest

from benchmarks.agents.fake_endpoint import FakeEndpoint, Request, Response, completion, error
from tests import tiny
from tests.agents.vlm import helpers, runs
from tests.faults import clients
from tests.forked import ForkedClient
from tests.serving import Server

EPISODES = 4


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    runs.write(tmp_path / "data", EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0", log=tmp_path / "server.log")
    yield server
    assert server.stop() == 0


def finished(process: ForkedClient, status: int = 0) -> str:
    said, _ = process.communicate(timeout=300)
    assert process.returncode == status, said
    return said


def key_in_files(folder: Path) -> list[Path]:
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert len(files) > 3
    return [path for path in files if helpers.KEY.encode() in path.read_bytes()]


PRICES = "[models.m]\ninput = 1.0\noutput = 2.0\n"


def test_a_run_in_both_languages(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    fake.behaviour = runs.expert(EPISODES)
    prices = tmp_path / "prices.toml"
    prices.write_text(PRICES)
    given = ("--agent-arg", "seed=3", "--agent-arg", f"prices={prices}")
    process = runs.client(server.address, fake, tmp_path / "out", *given, language="en,hi")
    said = finished(process)
    languages: dict[str, dict[str, Any]] = {}
    for path in (tmp_path / "out").glob("*.json"):
        content = json.loads(path.read_text())
        if "agent_report" in content:
            languages[content["run"]["language"]] = content
    assert languages.keys() == {"en", "hi"}
    for language, content in languages.items():
        episodes = len(content["episodes"])
        assert set(content["actions"].values()) == {"".join(map(str, tiny.ACTIONS))}
        report = content["agent_report"]
        assert report["measured"]["calls"] == episodes * runs.CALLS + 1
        tokens = report["measured"]["tokens"]
        assert report["declared"]["price_usd"] == pytest.approx((tokens["prompt"] + 2 * tokens["completion"]) / 1e6)
        assert (report["sight"], report["noops"]) == ("passed", {})
        recorded = {each["name"]: each["value"] for each in content["run"]["agent_arguments"]}
        assert recorded.keys() == {"model", "endpoint", "plan", "seed", "prompts", "openai"}
        assert (recorded["seed"], recorded["openai"]) == ("3", openai.__version__)
        assert f"openai={openai.__version__}" in content["signature"]
        assert f"prompts={recorded['prompts']}" in content["signature"]
        assert content["run"]["language"] == language
    assert len(fake.requests) == (EPISODES + len(languages["hi"]["episodes"])) * runs.CALLS + 2
    assert helpers.KEY not in said
    assert key_in_files(tmp_path) == []


def test_a_run_by_words_and_tools(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    fake.behaviour = runs.expert(EPISODES)
    given = ("--agent-arg", "images=false", "--agent-arg", "answers=tools")
    finished(runs.client(server.address, fake, tmp_path / "out", *given, language="hi"))
    content = clients.results(tmp_path / "out")
    assert set(content["actions"].values()) == {"".join(map(str, tiny.ACTIONS))}
    assert content["run"]["sensors"] == ["depth", "segmentation"]
    assert content["agent_report"]["sight"] == "none"
    questions = [json.dumps(request["messages"][-1], ensure_ascii=False) for request in fake.requests]
    assert len(questions) == len(content["episodes"]) * runs.CALLS
    assert not [each for each in questions if "image_url" in each]
    assert "धारीदार लाल मग, 3.4 इकाई दूर, ठीक सामने" in questions[0]


def test_a_limit_stops_the_run_and_a_higher_one_resumes_it(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    fake.behaviour = runs.expert(EPISODES)
    output = tmp_path / "out"
    process = runs.client(server.address, fake, output, "--agent-arg", "max_calls=10")
    run_id = clients.run_id(process)
    said = finished(process, 4)
    assert "the next call could exceed max_calls=10: resume it with a higher limit to go on" in said
    (command,) = (line for line in said.splitlines() if line.endswith(f"--resume {run_id}"))
    assert "--agent-arg max_calls=HIGHER " in command
    assert "agents.vlm: 10 calls, " in said
    assert f"cost unknown: no prices; trace: {output}/{run_id}.vlm.jsonl" in said
    assert len(fake.requests) == 10
    said = finished(runs.client(server.address, fake, output, "--resume", run_id, "--agent-arg", "max_calls=99"))
    assert len(fake.requests) == EPISODES * runs.CALLS + 1
    assert clients.results(output)["agent_report"]["measured"]["calls"] == EPISODES * runs.CALLS + 1
    refused = runs.client(server.address, fake, output, "--resume", run_id, "--agent-arg", "window=1")
    assert "was started with" in finished(refused, 2)


def test_a_key_that_expires_in_the_middle(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    """It is repeated by the endpoint, and yet in no file and no message."""
    good = runs.expert(EPISODES)

    def expires(request: Request, number: int) -> Response:
        return good(request, number) if number < 9 else error(401, f"expired: {helpers.KEY}")

    fake.behaviour = expires
    process = runs.client(server.address, fake, tmp_path / "out")
    run_id = clients.run_id(process)
    said = finished(process, 4)
    assert "answered 401: expired: [key]. The key in OPENAI_API_KEY is not valid" in said
    assert f"--resume {run_id}" in said
    assert "Traceback" not in said
    assert helpers.KEY not in said
    assert key_in_files(tmp_path) == []
    fake.behaviour = good
    refused = len(fake.requests) - 9
    finished(runs.client(server.address, fake, tmp_path / "out", "--resume", run_id))
    assert len(fake.requests) == EPISODES * runs.CALLS + 1 + refused


def test_an_endpoint_that_is_overloaded(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    """The participant reads what it said, not where the agent raised it."""
    fake.behaviour = lambda *_: error(429, "slow down")
    more = ("--agent-arg", "sight=skip", "--agent-arg", "attempts=1", "--retries", "0")
    said = finished(runs.client(server.address, fake, tmp_path / "out", *more), 3)
    assert f"the endpoint {fake.url} answered 429: slow down, after 1 attempts (429)" in said
    assert "remove the cause, then resume" in said
    assert "4 failed attempts" in said
    assert "Traceback" not in said


def test_a_model_that_never_answers_usably_costs_no_episode(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    def prose(request: Request, number: int) -> Response:
        return completion(request, "I would rather talk.")

    fake.behaviour = prose
    more = ("--episodes", "1", "--agent-arg", "sight=mark", "--agent-arg", "max_calls=22")
    process = runs.client(server.address, fake, tmp_path / "out", *more)
    said = finished(process, 4)
    assert "max_calls=22" in said
    noops = [each for each in runs.trace_of(tmp_path / "out") if each["kind"] == "noop"]
    assert [each["unusable"] for each in noops] == ["json"] * 10
    assert len(fake.requests) == 22


def test_two_clients_with_one_trace_folder(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    """Of one run: the second one stops with clear words, and the first goes on."""
    expert, second_has_ended = runs.expert(EPISODES), threading.Event()

    def patient(request: Request, number: int) -> Response:
        second_has_ended.wait()
        return expert(request, number)

    fake.behaviour = patient
    first = runs.client(server.address, fake, tmp_path / "out")
    run_id = clients.run_id(first)
    try:
        while not fake.requests:
            assert first.poll() is None
            time.sleep(0.01)
        second = runs.client(server.address, fake, tmp_path / "out", "--resume", run_id)
        assert "another process plays this run and writes" in finished(second, 4)
    finally:
        second_has_ended.set()
    finished(first)
    assert len(fake.requests) == EPISODES * runs.CALLS + 1


def test_a_blind_route_stops_before_the_first_step(server: Server, tmp_path: Path, fake: FakeEndpoint) -> None:
    fake.behaviour = lambda request, _: completion(request, '{"shape": "circle", "colour": "red", "word": "HELLO"}')
    said = finished(runs.client(server.address, fake, tmp_path / "out"), 4)
    assert "the model m at" in said
    assert "does not see: it named none of 2 cards rightly" in said
    assert len(fake.requests) == 2
