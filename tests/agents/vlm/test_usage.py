"""Tokens as reported, prices as stated, and limits: what is unknown stays unknown."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from arramon_agents.vlm.settings import read_settings
from arramon_agents.vlm.usage import ModelUsage, Price, Tokens, read_price, tokens_of
from arramon_client.agent import Episode
from arramon_client.errors import AgentError, AgentLoadError, StopRun
from benchmarks.agents.fake_endpoint import FakeEndpoint, completion, error
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent

PRICES = "[models.m]\ninput = 2.0\ncached_input = 0.5\noutput = 10.0\n"


@pytest.mark.parametrize(
    ("reported", "tokens"),
    [
        ({"prompt_tokens": 10, "completion_tokens": 2}, Tokens(10, 2)),
        (
            {"prompt_tokens": 10, "completion_tokens": 2, "prompt_tokens_details": {"cached_tokens": 4}},
            Tokens(10, 2, 4),
        ),
        ({"prompt_tokens": 10, "completion_tokens": 2, "prompt_tokens_details": None}, Tokens(10, 2)),
        ({"prompt": 10, "completion": 2, "cached": 4}, Tokens(10, 2, 4)),
        ({"prompt_tokens": 10}, None),
        ({"prompt_tokens": -1, "completion_tokens": 2}, None),
        ({"prompt_tokens": "10", "completion_tokens": 2}, None),
        ({"prompt_tokens": True, "completion_tokens": 2}, None),
        (None, None),
        ([], None),
    ],
)
def test_reported_tokens(reported: Any, tokens: Tokens | None) -> None:
    assert tokens_of(reported) == tokens


@pytest.mark.parametrize(
    ("price", "tokens", "cost"),
    [
        (Price(2.0, 10.0), Tokens(1_000_000, 100_000), 3.0),
        (Price(2.0, 10.0, 0.5), Tokens(1_000_000, 0, 500_000), 1.25),
        (Price(2.0, 10.0), Tokens(1_000_000, 0, 500_000), 2.0),
        (Price(0.0, 0.0), Tokens(5, 5), 0.0),
    ],
)
def test_costs(price: Price, tokens: Tokens, cost: float) -> None:
    assert price.cost(tokens) == pytest.approx(cost)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[models", "are not TOML"),
        ("[models.m]\ninput = 1", "expected input and output"),
        ("[models.m]\ninput = 1\noutput = -1", "output of 'm' is -1"),
        ("[models.m]\ninput = 1\noutput = '1'", "output of 'm' is '1'"),
        ("[models.m]\ninput = 1\noutput = 1\nimages = 3", "expected input and output"),
    ],
)
def test_faults_of_a_price_file(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "prices.toml"
    path.write_text(text)
    with pytest.raises(AgentLoadError) as caught:
        read_price(str(path), "m")
    assert message in str(caught.value)


def usage(price: Price | None = None, **limits: Any) -> ModelUsage:
    return ModelUsage(read_settings({"model": "m", "prices": "p" if price else None, **limits}), price)


def test_unknown_tokens_make_the_totals_unknown() -> None:
    used = usage(Price(1.0, 1.0))
    used.add(Tokens(1_000_000, 0), 1, 1.0)
    assert used.as_json()["declared"] == {"price_usd": 1.0}
    used.add(None, 2, 1.0)
    assert used.as_json() == {
        "measured": {
            "calls": 2, "attempts": 3, "calls_without_tokens": 1, "seconds": 2.0,
            "tokens": {"prompt": None, "completion": None, "cached": None, "total": None},
        },
        "declared": {"price_usd": None},
    }  # fmt: skip
    assert usage().as_json()["declared"] == {"price_usd": None}


@pytest.mark.parametrize(
    ("limits", "calls", "message"),
    [
        ({"max_calls": 3}, 3, "has used 3 calls, and the next call could exceed max_calls=3"),
        ({"max_tokens": 350}, 3, "has used 330 tokens in 3 calls, and the next call could exceed max_tokens=350"),
        ({"max_cost": 0.00025}, 2, "has used $0.0002 in 2 calls, and the next call could exceed max_cost=0.00025"),
    ],
)
def test_limits(limits: dict[str, Any], calls: int, message: str) -> None:
    used = usage(Price(1.0, 1.0), **limits)
    for _ in range(calls):
        used.reserve()
        used.release()
        used.add(Tokens(100, 10), 1, 0.1)
    with pytest.raises(StopRun) as caught:
        used.reserve()
    assert message in str(caught.value)
    assert [caught.value.limit] == list(limits)


def test_open_calls_count_as_large_as_the_largest() -> None:
    used = usage(max_tokens=350)
    used.add(Tokens(100, 10), 1, 0.1)
    used.reserve()
    used.reserve()
    with pytest.raises(StopRun):
        used.reserve()


def test_limits_need_reported_tokens() -> None:
    used = usage(max_tokens=1000)
    used.add(None, 1, 0.1)
    with pytest.raises(StopRun, match=r"tokens of 1 calls are unknown .* so max_tokens cannot be kept: .* max_calls"):
        used.reserve()


def test_a_run_stops_at_its_limit_and_goes_on_with_a_higher_one(
    made: MakeAgent, fake: FakeEndpoint, tmp_path: Path
) -> None:
    """Limits count the whole run, what earlier processes used included."""
    prices = tmp_path / "prices.toml"
    prices.write_text(PRICES)

    async def play(limit: int) -> tuple[int, dict[str, Any]]:
        agent = made(max_calls=limit, prices=str(prices))
        done = 0
        async with helpers.playing(agent):
            try:
                for step in range(10):
                    await agent.act(helpers.seen(step))
                    done += 1
            except StopRun:
                pass
        return done, dict(agent.run_report())

    assert asyncio.run(play(4))[0] == 4
    done, report = asyncio.run(play(6))
    assert done == 6
    assert len(fake.requests) == report["measured"]["calls"] == 6
    tokens = report["measured"]["tokens"]
    cost = ((tokens["prompt"] - tokens["cached"]) * 2 + tokens["cached"] * 0.5 + tokens["completion"] * 10) / 1e6
    assert report["declared"]["price_usd"] == pytest.approx(cost, abs=1e-6)


def test_a_model_without_prices(made: MakeAgent, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    prices = tmp_path / "prices.toml"
    prices.write_text("[models.other]\ninput = 1\noutput = 1\n")
    made(prices=str(prices))
    assert "has no prices of m: costs are unknown" in caplog.text
    with pytest.raises(AgentLoadError, match="has no prices of 'm', so max_cost cannot be kept"):
        made(prices=str(prices), max_cost=1.0)


def test_a_reply_without_usage_stops_a_run_with_a_token_limit(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = lambda request, _: completion(request, '{"actions": ["left"]}', usage=False)

    async def play() -> None:
        async with helpers.playing(made(max_tokens=10_000)) as agent:
            await agent.act(helpers.seen(0))
            await agent.act(helpers.seen(1))

    with pytest.raises(StopRun, match="tokens of 1 calls are unknown"):
        asyncio.run(play())
    assert len(fake.requests) == 1


def test_the_first_calls_do_not_exceed_a_limit_together(made: MakeAgent, fake: FakeEndpoint) -> None:
    """How large a call is shows only after the first one, which the others wait for."""

    async def play() -> list[object]:
        async with helpers.playing(made(max_tokens=1)) as agent:
            for number in range(8):
                agent.begin(Episode(str(number), "en", "tiny"))
            acts = (agent.act(helpers.seen(0, episode_id=str(number))) for number in range(8))
            return await asyncio.gather(*acts, return_exceptions=True)

    outcomes = asyncio.run(play())
    assert sum(isinstance(each, StopRun) for each in outcomes) == 7
    assert len(fake.requests) == 1


def test_a_filtered_call_takes_no_tokens(made: MakeAgent, fake: FakeEndpoint) -> None:
    """So that it does not end a run with a limit of tokens."""
    fake.behaviour = helpers.in_turn(lambda *_: error(400, "filtered", "content_filter"), helpers.always("forward"))

    async def play() -> Any:
        async with helpers.playing(made(max_tokens=100_000)) as agent:
            await agent.act(helpers.seen(0))
            return agent.run_report()["measured"]

    measured = asyncio.run(play())
    assert (measured["calls"], measured["calls_without_tokens"]) == (2, 0)
    assert measured["tokens"]["total"] > 0


def test_failed_attempts_are_counted_also_after_a_resumption(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(*[lambda *_: error(500, "oops", "")] * 3, helpers.always("forward"))

    async def play() -> Any:
        async with helpers.playing(made(attempts=3)) as agent:
            await agent.act(helpers.seen(0))
        return agent.run_report()["measured"]

    with pytest.raises(AgentError):
        asyncio.run(play())
    measured = asyncio.run(play())
    assert (measured["calls"], measured["attempts"], len(fake.requests)) == (1, 4, 4)


@pytest.mark.parametrize(
    ("given", "tokens", "line"),
    [
        ({}, [Tokens(1000, 10), Tokens(500, 5)], "2 calls, 1,500 tokens read, 15 written, cost unknown: no prices"),
        ({"price": Price(2.0, 10.0)}, [Tokens(1000, 10)], "1 calls, 1,000 tokens read, 10 written, $0.0021"),
        ({"price": Price(2.0, 10.0)}, [Tokens(1000, 10), None],
         "2 calls; tokens and cost unknown: 1 calls report none"),
        ({}, [], "0 calls, 0 tokens read, 0 written, cost unknown: no prices"),
    ],
)  # fmt: skip
def test_summary(given: dict[str, Any], tokens: list[Tokens | None], line: str) -> None:
    used = ModelUsage(read_settings({"model": "m"}), given.get("price"))
    for each in tokens:
        used.add(each, 1, 0.1)
    assert used.summary() == line
    used.attempts += 2
    assert "calls and 2 failed attempts" in used.summary()
