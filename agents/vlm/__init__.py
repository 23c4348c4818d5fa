"""Agent that asks a language model behind an OpenAI-compatible endpoint (extra `vlm`).

The package `openai` is imported when the agent is made, so that other agents work without it.
"""

from typing import TYPE_CHECKING, Any

from arramon_agents.requirements import require

if TYPE_CHECKING:
    from arramon_agents.vlm.agent import VlmAgent

__all__ = ["make_agent"]

REQUIRED = ("openai", "PIL")
"""Modules of the extra."""


def make_agent(
    model: str,
    endpoint: str = "https://api.openai.com/v1",
    key_variable: str = "OPENAI_API_KEY",
    plan: int = 4,
    window: int = 4,
    answers: str = "schema",
    images: bool = True,
    image_size: int = 0,
    image_format: str = "png",
    detail: str = "auto",
    temperature: float | None = None,
    seed: int | None = None,
    reply_tokens: int = 1024,
    extra: dict[str, Any] | None = None,
    prompts: str | None = None,
    sight: str = "check",
    timeout: float = 120.0,
    attempts: int = 5,
    concurrency: int = 8,
    max_calls: int | None = None,
    max_tokens: int | None = None,
    max_cost: float | None = None,
    prices: str | None = None,
    trace: str | None = None,
) -> "VlmAgent":
    """Return the agent.

    Args:
        model: the model's name at the endpoint.
        endpoint: base URL of the endpoint, without credentials: arguments are public with the run.
        key_variable: environment variable that holds the key.
        plan: the most actions that one reply may plan.
        window: number of earlier exchanges of the phase that are sent with each call.
        answers: "schema" (JSON by `response_format` json_schema), "object" (json_object), "plain" (JSON without
            `response_format`) or "tools" (a call of the tool `act`).
        images: whether to send frames; otherwise words that say what stands where, from depth and segmentation.
        image_size: side length of the frames sent, in pixels; 0 for the run's own.
        image_format: "png" or "jpeg".
        detail: "auto", "low" or "high".
        temperature: of sampling; None for the endpoint's default.
        seed: sent with each call; None to send none.
        reply_tokens: the most tokens of one reply.
        extra: further fields of each request, such as {"reasoning_effort": "low"}.
        prompts: a TOML file with the keys of `prompts/en.toml`, used in every language; None for the shipped ones.
        sight: "check" to refuse a route on which the model does not see a drawn card, "mark" to play on and mark the
            run, "skip" not to check.
        timeout: seconds for one attempt of a call.
        attempts: attempts of a call whose failure is temporary.
        concurrency: the most calls at the same time.
        max_calls, max_tokens, max_cost: limits of the run, in calls, tokens and US dollars; at the first one the run
            stops and can be resumed, with higher limits if you like.
        prices: a TOML file with prices per million tokens; see docs/how-to/models.md.
        trace: folder of the trace `RUN.vlm.jsonl`; None for that of the results.

    Raises:
        AgentLoadError: if the extra is not installed, an argument is wrong, or there is no key.
    """
    given = dict(locals())
    require(REQUIRED, "agents.vlm", "vlm")
    from arramon_agents.vlm.agent import VlmAgent
    from arramon_agents.vlm.settings import read_settings

    return VlmAgent(read_settings(given))
