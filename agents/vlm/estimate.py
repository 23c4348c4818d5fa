"""Estimates of a run's calls, tokens and cost, from the settings or from the trace of a few episodes."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from arramon_agents.vlm.prompt_texts import PromptFolder, Prompts
from arramon_agents.vlm.records import paid_reply
from arramon_agents.vlm.settings import ModelSettings
from arramon_agents.vlm.usage import Price, Tokens
from arramon_client.errors import AgentLoadError
from arramon_client.world import ASSEMBLY, NAVIGATION, PHASES, STEPS_PER_PHASE, TURNS

EXPERT_STEPS: Mapping[str, float] = {NAVIGATION: 36.0, ASSEMBLY: 6.0}
"""Mean steps of the ground truth in a phase of `val_seen`."""

DETOUR = 2.0
"""Steps of a model that arrives, as a multiple of the ground truth's: it looks around, and corrects itself."""

INSTRUCTION = "x" * 250
"""An instruction of usual length."""

REPLY_CHARACTERS = 160
"""Characters of a reply without its actions: JSON, and one short sentence."""

ACTION_CHARACTERS = 11
"""Characters of one action in a reply."""

SCENE_CHARACTERS = 700
"""Characters that describe a view in words."""

ATTEMPTS = 2
"""Replies before a step at most: an unusable one is asked for once more."""


@dataclass(frozen=True)
class Estimate:
    """Calls and tokens of a run.

    Attributes:
        calls: number of calls.
        prompt: tokens read.
        completion: tokens written.
        cached: the part of `prompt` that is cached; None to expect none.
    """

    calls: float
    prompt: float
    completion: float
    cached: float | None = None

    def times(self, factor: float) -> "Estimate":
        """Return the estimate multiplied."""
        cached = None if self.cached is None else self.cached * factor
        return Estimate(self.calls * factor, self.prompt * factor, self.completion * factor, cached)

    def cost(self, price: Price | None) -> float | None:
        """Return the cost in US dollars; None if there are no prices."""
        if price is None:
            return None
        cached = None if self.cached is None else round(self.cached)
        return price.cost(Tokens(round(self.prompt), round(self.completion), cached))


@dataclass(frozen=True)
class TokenRates:
    """Assumptions about an unknown tokenizer.

    Attributes:
        characters: characters of a token.
        image: tokens of a frame.
    """

    characters: float
    image: int


def rates_of(settings: ModelSettings, price: Price | None, language: str, size: int) -> TokenRates:
    """Return usual rates: 4 characters a token in English, 2 in other languages; an image by tiles of 512 pixels.

    Args:
        settings: the agent's settings.
        price: prices, which may state the tokens of a frame.
        language: of prompts and instructions.
        size: side length of a frame in pixels.
    """
    image = price.image_tokens if price is not None else None
    if image is None:
        image = 85 if settings.detail == "low" else 85 + 170 * math.ceil(size / 512) ** 2
    return TokenRates(4.0 if language == "en" else 2.0, image if settings.images else 0)


def estimate_episode(settings: ModelSettings, prompts: Prompts, rates: TokenRates, *, at_most: bool) -> Estimate:
    """Return the estimate for one episode.

    Args:
        settings: the agent's settings.
        prompts: of the instructions' language.
        rates: tokens of texts and frames.
        at_most: whether to assume that every phase takes all its steps, one action a call, and every reply is asked for
            twice; otherwise that the model arrives, with full plans.
    """
    total = Estimate(0, 0, 0)
    kind = "tools" if settings.answers == "tools" else "json"
    answer = prompts.text(f"answer.{kind}", plan=settings.plan)
    for phase in PHASES:
        task = prompts.text(f"task.{phase}", turn=1, instruction=INSTRUCTION)
        system = len(prompts.text("system")) + len(answer) + len(task)
        steps = STEPS_PER_PHASE if at_most else EXPERT_STEPS[phase] * DETOUR
        planned = 1 if at_most else min(settings.plan, steps)
        calls = steps / planned
        question = len(prompts.text("observation.now", phase_step=100, steps_left=100)) + 60
        question += 0 if settings.images else SCENE_CHARACTERS
        reply = (REPLY_CHARACTERS + ACTION_CHARACTERS * planned) / rates.characters
        asked = question / rates.characters + rates.image
        window = sum(min(number, settings.window) for number in range(math.ceil(calls)))
        prompt = calls * (system / rates.characters + asked) + window * (asked + reply)
        factor = TURNS * (ATTEMPTS if at_most else 1)
        completion = calls * (settings.reply_tokens if at_most else reply)
        total = Estimate(
            total.calls + factor * calls, total.prompt + factor * prompt, total.completion + factor * completion
        )
    return total


def estimate_from_trace(records: Iterable[Mapping[str, Any]]) -> tuple[int, Estimate]:
    """Return the number of whole episodes of a trace, and the mean per episode of what was measured.

    Raises:
        AgentLoadError: if it has no calls of a whole episode, or a call whose tokens the endpoint did not report.
    """
    records = list(records)
    ended = {str(record.get("episode")) for record in records if record.get("kind") == "end"}
    episodes: set[str] = set()
    calls = prompt = completion = cached = 0
    for record in records:
        paid = paid_reply(record)
        if paid is None or str(record.get("episode")) not in ended:
            continue
        if paid.tokens is None:
            raise AgentLoadError("the trace holds calls whose tokens the endpoint did not report")
        episodes.add(str(record.get("episode")))
        calls += 1
        prompt += paid.tokens.prompt
        completion += paid.tokens.completion
        cached += paid.tokens.cached or 0
    if not episodes:
        raise AgentLoadError("the trace holds no whole episode: play a few to their end with --episodes first")
    return len(episodes), Estimate(calls, prompt, completion, cached).times(1 / len(episodes))


def prompts_of(settings: ModelSettings, language: str) -> Prompts:
    """Return the prompts of a language."""
    return PromptFolder(settings.prompts, lambda _: None).of(language)


def shown(name: str, estimate: Estimate, price: Price | None) -> str:
    """Return a line of the estimate."""
    cost = estimate.cost(price)
    money = "cost unknown: no prices" if cost is None else f"${cost:,.2f}"
    read, wrote = _rounded(estimate.prompt), _rounded(estimate.completion)
    return f"{name:<12}{_rounded(estimate.calls):>10} calls{read:>15} tokens read{wrote:>13} written   {money}"


def _rounded(number: float) -> str:
    """Return a number with three significant digits: more would claim more than is known."""
    digits = max(0, math.floor(math.log10(number)) - 2) if number >= 1 else 0
    return f"{round(number, -digits):,.0f}"
