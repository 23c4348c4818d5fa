"""The estimate makes no call, and agrees with what a run then takes."""

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest

from arramon_agents.vlm import __main__ as command
from arramon_agents.vlm import estimate
from arramon_agents.vlm.settings import read_settings
from benchmarks.agents.fake_endpoint import FakeEndpoint
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert command.main(["estimate", *arguments]) == 0
    return capsys.readouterr().out


def test_the_command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a key, too."""
    monkeypatch.delenv("OPENAI_API_KEY")
    text = said(capsys, "--episodes", "10", "--agent-arg", "model=m")
    assert "m, 10 episodes, plan=4, window=4:" in text
    assert "12,000 calls" in text  # 4 phases of 150 steps, each asked for twice
    assert text.count("cost unknown: no prices") == 2
    prices = tmp_path / "prices.toml"
    prices.write_text("[models.m]\ninput = 1.0\noutput = 2.0\nimage_tokens = 100\n")
    priced = said(capsys, "--episodes", "10", "--agent-arg", "model=m", "--agent-arg", f"prices={prices}")
    assert priced.count("$") == 2
    assert "100 tokens a frame" in priced


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--episodes", "0", "--agent-arg", "model=m"], "--episodes is 0; expected 1 or more"),
        (["--episodes", "1"], "requires the argument 'model'"),
        (["--episodes", "1", "--agent-arg", "model=m", "--agent-arg", "plan=0"], "plan is '0'"),
        (["--episodes", "1", "--agent-arg", "model=m", "--trace", "/nowhere"], "/nowhere cannot be read: No such"),
        (["--episodes", "1", "--agent-arg", "model=m", "--trace", "/dev/null"], "holds no whole episode"),
    ],
)
def test_wrong_arguments(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["estimate", *arguments]) == command.FAILED
    assert message in capsys.readouterr().err


def test_from_the_trace_of_some_episodes(
    made: MakeAgent, fake: FakeEndpoint, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    agent = made(window=0, sight="mark")

    async def play() -> None:
        async with helpers.playing(agent):
            for step in range(5):
                await agent.act(helpers.seen(step))
            agent.end("e")
            agent.begin(replace(helpers.EPISODE, episode_id="stopped"))
            await agent.act(helpers.seen(0, episode_id="stopped"))

    asyncio.run(play())
    calls, tokens = len(fake.requests) - 2, agent.run_report()["measured"]["tokens"]
    trace = tmp_path / "r.vlm.jsonl"
    text = said(capsys, "--episodes", "20", "--agent-arg", "model=m", "--trace", str(trace))
    assert "by the 1 episode of" in text
    assert f"{calls * 20} calls" in text
    assert tokens["prompt"] > 0


def test_more_actions_a_call_are_cheaper_and_a_longer_window_dearer() -> None:
    def prompt(**given: object) -> float:
        settings = read_settings({"model": "m", **given})
        rates = estimate.rates_of(settings, None, "en", 224)
        prompts = estimate.prompts_of(settings, "en")
        return estimate.estimate_episode(settings, prompts, rates, at_most=False).prompt

    assert prompt(plan=8) < prompt(plan=4) < prompt(plan=1)
    assert prompt(window=0) < prompt(window=2) < prompt(window=8)
    assert prompt(detail="low") < prompt()
