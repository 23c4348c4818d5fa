"""An endpoint that answers badly: what the agent does, and what the participant reads."""

import asyncio
import json
import threading
import time
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from pathlib import Path
from types import SimpleNamespace

import pytest

from arramon_agents.vlm import endpoint as endpoint_module
from arramon_client.agent import Action, Episode
from arramon_client.errors import AgentError, StopRun
from benchmarks.agents import fake_endpoint
from benchmarks.agents.fake_endpoint import Behaviour, FakeEndpoint, Request, Response, completion, error, plan
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent

GOOD = helpers.always("forward")


def text(content: str | None, **given: object) -> Behaviour:
    return lambda request, number: completion(request, content, **given)  # type: ignore[arg-type]


def status(code: int, message: str = "no", name: str = "", **headers: str) -> Behaviour:
    sent = {key.replace("_", "-"): value for key, value in headers.items()}
    return lambda request, number: error(code, message, name, sent)


def body(content: bytes, **given: object) -> Behaviour:
    return lambda request, number: Response(content, **given)  # type: ignore[arg-type]


def tools(*calls: tuple[str, str]) -> Behaviour:
    return lambda request, number: completion(request, None, tools=calls)


HTML = body(b"<!doctype html><title>Sign in</title>", headers={"Content-Type": "text/html"})
SOON = format_datetime(datetime.now(UTC) - timedelta(seconds=1))

# What the endpoint answers first, before good answers; the answer to expect after how many requests.
PASSING: list[tuple[str, list[Behaviour], int]] = [
    ("429 without a time", [status(429), status(429)], 3),
    ("429 with a time", [status(429, retry_after="0.01"), status(429, retry_after_ms="5")], 3),
    ("429 with a date", [status(429, retry_after=SOON)], 2),
    ("429 with a time, more often than attempts", [status(429, retry_after="0.001")] * 5, 6),
    ("429 with nonsense", [status(429, retry_after="soon")], 2),
    ("500", [status(500), status(503)], 3),
    ("408", [status(408)], 2),
    ("closed", [body(b"", closes=True)], 2),
    ("cut in the middle", [body(b'{"choices": []}' * 50, cut=True)], 2),
    ("a web page", [HTML, HTML], 3),
    ("an empty body", [body(b"")], 2),
    ("half of a JSON text", [body(b'{"choices": [{"mess')], 2),
    ("JSON of another kind", [body(b'{"detail": "hello"}'), body(b"[]")], 3),
    ("no choices", [body(b'{"choices": []}'), body(b'{"choices": null}')], 3),
    ("choices of another form", [body(b'{"choices": [{"message": {"tool_calls": 3}}]}')], 2),
    ("an empty reply", [text(""), ], 2),
    ("null", [text(None)], 2),
    ("prose", [text("Let me go forward.")], 2),
    ("wrong JSON", [text('{"move": 1}')], 2),
    ("cut off", [text('{"actions": ["for', finish="length")], 2),
    ("an unknown tool", [tools(("fly", "{}"))], 2),
    ("repeats itself", [text('{"actions": ["forward"]}' * 400)], 2),
    ("10 MB", [text("forward " * 1_250_000)], 2),
    ("a refusal", [text(None, refusal="I cannot help with that.")], 2),
    ("a filter", [status(400, "filtered", "content_filter")], 2),
    ("no usage", [text("?", usage=False)], 2),
]  # fmt: skip


@pytest.mark.parametrize(("behaviours", "requests"), [each[1:] for each in PASSING], ids=[each[0] for each in PASSING])
def test_what_passes(behaviours: list[Behaviour], requests: int, made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(*behaviours, GOOD)

    async def play() -> int:
        async with helpers.playing(made()) as agent:
            return await helpers.action_of(agent, helpers.seen(0))

    assert asyncio.run(play()) == Action.FORWARD
    assert len(fake.requests) == requests


# What the endpoint answers always; the error to expect after how many requests, and its message.
FAILING: list[tuple[str, Behaviour, type[Exception], int, str]] = [
    ("401", status(401, "Incorrect API key provided"), StopRun, 1,
     "answered 401: Incorrect API key provided. The key in OPENAI_API_KEY is not valid, or has expired"),
    ("403", status(403, "denied"), StopRun, 1, "answered 403: denied. The key in OPENAI_API_KEY is not valid"),
    ("404", status(404, "no such model"), StopRun, 1, "There is no model 'm', or the endpoint's path is wrong"),
    ("400", status(400, "response_format is not supported"), StopRun, 1,
     "response_format is not supported. If it does not support this form of answers, choose another"),
    ("no credit", status(429, "You exceeded your quota", "insufficient_quota"), StopRun, 1, "429: You exceeded"),
    ("429 for an hour", status(429, "slow down", retry_after="3600"), StopRun, 1, "it asks to wait 3600 s"),
    ("429", status(429, "slow down"), AgentError, 3, "429: slow down, after 3 attempts (429, 429, 429)"),
    ("500", status(500, "oops"), AgentError, 3, "answered 500: oops, after 3 attempts (500, 500, 500)"),
    ("500 with a page", body(b"<html>bad gateway</html>", status=502), AgentError, 3, "answered 502, after 3 attempts"),
    ("closed", body(b"", closes=True), AgentError, 3, "cannot be reached: "),
    ("a web page", HTML, StopRun, 3, "a web page: check --agent-arg endpoint (its path often ends in /v1), after 3"),
    ("no JSON", body(b"hello"), StopRun, 3, "answered with what is not JSON, or was truncated"),
    ("JSON of another kind", body(b"{}"), StopRun, 3, "answered with JSON that is not a chat completion"),
    ("nothing", body(b""), StopRun, 3, "answered with an empty body, after 3 attempts (empty body, empty body, "),
]  # fmt: skip


@pytest.mark.parametrize(
    ("behaviour", "kind", "requests", "message"), [each[1:] for each in FAILING], ids=[each[0] for each in FAILING]
)
def test_what_fails(
    behaviour: Behaviour, kind: type[Exception], requests: int, message: str, made: MakeAgent, fake: FakeEndpoint
) -> None:
    """The next `act` for the same observation goes on as if nothing had been."""
    fake.behaviour = behaviour

    async def play() -> int:
        async with helpers.playing(made()) as agent:
            with pytest.raises(kind) as caught:
                await agent.act(helpers.seen(0))
            assert message in str(caught.value)
            assert len(fake.requests) == requests
            fake.behaviour = GOOD
            return await helpers.action_of(agent, helpers.seen(0))

    assert asyncio.run(play()) == Action.FORWARD


def test_an_endpoint_that_is_away(made: MakeAgent) -> None:
    async def play() -> None:
        async with helpers.playing(made(endpoint="http://127.0.0.1:9/v1")) as agent:
            await agent.act(helpers.seen(0))

    with pytest.raises(AgentError, match=r"http://127\.0\.0\.1:9/v1 cannot be reached: .*after 3 attempts"):
        asyncio.run(play())


def test_a_slow_endpoint(made: MakeAgent, fake: FakeEndpoint) -> None:
    def slow(request: Request, number: int) -> Response:
        return Response(plan(request, ["forward"]).body, delay=0.0 if number else 2.0)

    fake.behaviour = slow

    async def play() -> int:
        async with helpers.playing(made(timeout=0.5, attempts=50)) as agent:
            return await helpers.action_of(agent, helpers.seen(0))

    assert asyncio.run(play()) == Action.FORWARD
    assert len(fake.requests) >= 2


def test_a_key_that_expires_in_the_middle(made: MakeAgent, fake: FakeEndpoint) -> None:
    """The run stops, and goes on with another key without repeating a call."""
    fake.behaviour = helpers.in_turn(GOOD, GOOD, status(401, "expired"))

    async def play() -> list[int]:
        async with helpers.playing(made()) as agent:
            return [await helpers.action_of(agent, helpers.seen(step)) for step in range(3)]

    with pytest.raises(StopRun, match="401: expired"):
        asyncio.run(play())
    fake.behaviour = GOOD
    assert asyncio.run(play()) == [0, 0, 0]
    assert len(fake.requests) == 3 + 1


def test_a_rate_limit_with_a_time_holds_all_calls(made: MakeAgent, fake: FakeEndpoint) -> None:
    limited = status(429, "slow down", retry_after="0.3")
    arrivals: list[float] = []

    def behaviour(request: Request, number: int) -> Response:
        arrivals.append(time.monotonic())
        return (limited if number == 0 else GOOD)(request, number)

    fake.behaviour = behaviour

    async def play() -> None:
        async with helpers.playing(made(concurrency=1)) as agent:
            agent.begin(helpers.EPISODE)
            others = [Episode(str(number), "en", "tiny") for number in range(3)]
            for each in others:
                agent.begin(each)
            seen = [helpers.seen(0, episode_id=each.episode_id) for each in others]
            await asyncio.gather(*map(agent.act, seen))

    asyncio.run(play())
    assert len(arrivals) == 4
    assert arrivals[1] - arrivals[0] >= 0.3


def test_a_rate_limit_that_names_no_time_to_wait(
    made: MakeAgent, fake: FakeEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`Retry-After: 0` without end stops the run as a long wait does."""
    monkeypatch.setattr(endpoint_module, "SHORTEST_WAIT", 0.004)
    monkeypatch.setattr(endpoint_module, "LONGEST_WAIT", 0.01)
    fake.behaviour = status(429, "slow down", retry_after="0")

    async def play() -> None:
        async with helpers.playing(made()) as agent:
            await agent.act(helpers.seen(0))

    with pytest.raises(StopRun, match="429: slow down; it asks to wait"):
        asyncio.run(play())
    assert len(fake.requests) == 3


def test_at_most_so_many_calls_at_the_same_time(
    made: MakeAgent, fake: FakeEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each call is answered when two others are open beside it."""
    three = threading.Barrier(3, timeout=240.0)
    monkeypatch.setattr(fake_endpoint, "time", SimpleNamespace(sleep=lambda _: three.wait()))
    fake.behaviour = lambda request, number: plan(request, ["left"])

    async def play() -> None:
        async with helpers.playing(made(concurrency=3)) as agent:
            for number in range(9):
                agent.begin(Episode(str(number), "en", "tiny"))
            await asyncio.gather(*(agent.act(helpers.seen(0, episode_id=str(number))) for number in range(9)))

    asyncio.run(play())
    assert fake.most_open == 3
    assert len(fake.requests) == 9


def test_the_key_is_in_no_message_and_no_file(made: MakeAgent, fake: FakeEndpoint, tmp_path: Path) -> None:
    """Even if the endpoint repeats it."""
    thought = json.dumps({"thought": f"I was sent {helpers.KEY}", "actions": ["forward"]})
    fake.behaviour = helpers.in_turn(
        text(thought),
        status(500, f"your key {helpers.KEY}"),
        status(401, f"bad key: {helpers.KEY}"),
    )
    notes = []

    async def play() -> None:
        async with helpers.playing(made()) as agent:
            notes.append(await helpers.note_of(agent, helpers.seen(0)))
            await agent.act(helpers.seen(1))

    with pytest.raises(StopRun, match=r"bad key: \[key\]"):
        asyncio.run(play())
    assert fake.keys == [f"Bearer {helpers.KEY}"] * 3
    assert [note["thought"] for note in notes] == ["I was sent [key]"]
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert files
    assert not [path for path in files if helpers.KEY.encode() in path.read_bytes()]


def test_requests(made: MakeAgent, fake: FakeEndpoint) -> None:
    async def play(**given: object) -> Request:
        async with helpers.playing(made(**given), str(len(fake.requests))) as agent:
            await agent.act(helpers.seen(0))
        return fake.requests[-1]

    plain = asyncio.run(play(answers="plain", reply_tokens=50))
    assert plain.keys() == {"model", "messages", "max_tokens"}
    assert plain["max_tokens"] == 50
    more = asyncio.run(play(answers="object", seed=3, temperature=0.5, extra={"reasoning_effort": "low"}))
    assert {key: more[key] for key in ("seed", "temperature", "reasoning_effort", "response_format")} == {
        "seed": 3, "temperature": 0.5, "reasoning_effort": "low", "response_format": {"type": "json_object"},
    }  # fmt: skip
    form = asyncio.run(play())["response_format"]["json_schema"]
    assert form["strict"] is True
    assert form["schema"]["required"] == ["thought", "actions"]
    called = asyncio.run(play(answers="tools"))
    assert called["tool_choice"] == {"type": "function", "function": {"name": "act"}}
    assert json.dumps(called).count('"additionalProperties": false') == 1


def test_a_refusal_without_a_key_asks_for_one(
    made: MakeAgent, fake: FakeEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY")
    fake.behaviour = status(401, "who are you?")

    async def play() -> None:
        async with helpers.playing(made()) as agent:
            await helpers.action_of(agent, helpers.seen(0))

    with pytest.raises(StopRun, match=r"401: who are you\?\. No key was sent, as OPENAI_API_KEY is not set") as caught:
        asyncio.run(play())
    assert "not valid" not in str(caught.value)


def test_the_stand_in_answers_at_its_path_alone(made: MakeAgent, fake: FakeEndpoint) -> None:
    async def play() -> None:
        async with helpers.playing(made(endpoint=fake.url.removesuffix("/v1"))) as agent:
            await helpers.action_of(agent, helpers.seen(0))

    with pytest.raises(StopRun, match=r"404: there is nothing at /chat/completions.*often it ends in /v1"):
        asyncio.run(play())
    assert fake.requests == []
