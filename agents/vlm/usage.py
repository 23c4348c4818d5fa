"""Usage of an endpoint: tokens as the provider counts them, prices as the user states them, and limits of a run."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

from arramon_agents.vlm.settings import ModelSettings
from arramon_client.errors import AgentLoadError, StopRun


@dataclass(frozen=True)
class Tokens:
    """Tokens of one call, as the endpoint reports them.

    Attributes:
        prompt: tokens read, including `cached`.
        completion: tokens written.
        cached: the part of `prompt` that was in the endpoint's cache; None if it does not say.
    """

    prompt: int
    completion: int
    cached: int | None = None

    @property
    def total(self) -> int:
        """Tokens read and written."""
        return self.prompt + self.completion

    def as_json(self) -> dict[str, int]:
        """Return the numbers that are known."""
        known = {"prompt": self.prompt, "completion": self.completion}
        return known if self.cached is None else {**known, "cached": self.cached}


def tokens_of(content: object) -> Tokens | None:
    """Return the tokens of a completion's field `usage`, or of `Tokens.as_json`; None if they are not reported."""
    if not isinstance(content, dict):
        return None
    details = content.get("prompt_tokens_details")
    cached = details.get("cached_tokens") if isinstance(details, dict) else content.get("cached")
    prompt = content.get("prompt_tokens", content.get("prompt"))
    completion = content.get("completion_tokens", content.get("completion"))
    if not (_is_count(prompt) and _is_count(completion)):
        return None
    return Tokens(prompt, completion, cached if _is_count(cached) else None)


def _is_count(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 10**12


@dataclass(frozen=True)
class Price:
    """Prices of a model, in US dollars per million tokens.

    Attributes:
        input: of tokens read.
        output: of tokens written.
        cached_input: of cached tokens; None if they cost as much as others.
        image_tokens: tokens of one frame, for estimates; None if unknown.
    """

    input: float
    output: float
    cached_input: float | None = None
    image_tokens: int | None = None

    def cost(self, tokens: Tokens) -> float:
        """Return the price of a call in US dollars."""
        cached = min(tokens.cached or 0, tokens.prompt)
        cached_price = self.input if self.cached_input is None else self.cached_input
        read = (tokens.prompt - cached) * self.input + cached * cached_price
        return (read + tokens.completion * self.output) / 1e6


def read_price(path: str | None, model: str) -> Price | None:
    """Return a model's prices from a file with a table `[models."NAME"]`; None if there is no file or no table.

    Raises:
        AgentLoadError: if the file cannot be read, or a price is not a number.
    """
    if path is None:
        return None
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise AgentLoadError(f"agents.vlm: prices {path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise AgentLoadError(f"agents.vlm: prices {path} are not TOML: {error}") from error
    models = content.get("models", {})
    table = models.get(model) if isinstance(models, dict) else None
    if table is None:
        return None
    expected = 'expected input and output, US dollars per million tokens, e.g. [models."NAME"] input = 1.25'
    allowed = ("input", "output", "cached_input", "image_tokens")
    if not isinstance(table, dict) or not {"input", "output"} <= table.keys() <= set(allowed):
        raise AgentLoadError(f"agents.vlm: prices {path}: the table of {model!r} is {table!r}; {expected}")
    for name, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1e9:
            raise AgentLoadError(f"agents.vlm: prices {path}: {name} of {model!r} is {value!r}; {expected}")
    return Price(**table)


@dataclass
class ModelUsage:
    """What a run has used so far, with its limits.

    Attributes:
        calls: answered calls.
        attempts: attempts of all calls, those without an answer included.
        tokens: tokens of the calls whose tokens the endpoint reported.
        unreported: number of answered calls whose tokens it did not report.
        seconds: duration of all calls together.
    """

    settings: ModelSettings
    price: Price | None
    calls: int = 0
    attempts: int = 0
    prompt: int = 0
    completion: int = 0
    cached: int | None = None
    unreported: int = 0
    seconds: float = 0.0
    _cost: float = 0.0
    _largest_tokens: int = 0
    _largest_cost: float = 0.0
    _open: int = 0

    @property
    def cost(self) -> float | None:
        """Price of all calls in US dollars; None if it is not known."""
        return self._cost if self.price is not None and not self.unreported else None

    def reserve(self) -> None:
        """Count a call as open, if it fits the limits even if it is as large as the largest so far.

        Raises:
            StopRun: if it does not fit; the message names the limit.
        """
        limits, open_calls = self.settings, self._open + 1
        if limits.max_calls is not None and self.calls + open_calls > limits.max_calls:
            raise self._stop(f"max_calls={limits.max_calls}", f"{self.calls} calls")
        if self.unreported and (limits.max_tokens is not None or limits.max_cost is not None):
            limit = "max_tokens" if limits.max_tokens is not None else "max_cost"
            raise StopRun(
                f"the tokens of {self.unreported} calls are unknown (not reported, or the answer was too large), so "
                f"{limit} cannot be kept: resume the run with max_calls instead"
            )
        spent = self.prompt + self.completion
        if limits.max_tokens is not None and spent + open_calls * self._largest_tokens > limits.max_tokens:
            raise self._stop(f"max_tokens={limits.max_tokens}", f"{spent} tokens in {self.calls} calls")
        if limits.max_cost is not None and self._cost + open_calls * self._largest_cost > limits.max_cost:
            raise self._stop(f"max_cost={limits.max_cost:g}", f"${self._cost:.4f} in {self.calls} calls")
        self._open += 1

    def release(self) -> None:
        """Count a call as no longer open, answered or not."""
        self._open -= 1

    def add(self, tokens: Tokens | None, attempts: int, seconds: float) -> None:
        """Count an answered call."""
        self.calls += 1
        self.attempts += attempts
        self.seconds += seconds
        if tokens is None:
            self.unreported += 1
            return
        self.prompt += tokens.prompt
        self.completion += tokens.completion
        if tokens.cached is not None:
            self.cached = (self.cached or 0) + tokens.cached
        self._largest_tokens = max(self._largest_tokens, tokens.total)
        if self.price is not None:
            cost = self.price.cost(tokens)
            self._cost += cost
            self._largest_cost = max(self._largest_cost, cost)

    @property
    def is_unmeasured(self) -> bool:
        """Whether limits of tokens or money are set, and no call has shown yet how large calls are."""
        limits = self.settings
        return not self._largest_tokens and (limits.max_tokens is not None or limits.max_cost is not None)

    def summary(self) -> str:
        """Return a line with calls, tokens and cost; what is unknown is called so."""
        failed = self.attempts - self.calls
        attempts = f" and {failed:,} failed attempts" if failed else ""
        if self.unreported:
            return f"{self.calls:,} calls{attempts}; tokens and cost unknown: {self.unreported:,} calls report none"
        cost = f"${self._cost:,.4f}" if self.price is not None else "cost unknown: no prices"
        return f"{self.calls:,} calls{attempts}, {self.prompt:,} tokens read, {self.completion:,} written, {cost}"

    def as_json(self) -> dict[str, Any]:
        """Return what was measured, and apart from it what follows from the user's prices; null is unknown."""
        whole = not self.unreported
        tokens: Mapping[str, int | None] = {
            "prompt": self.prompt if whole else None,
            "completion": self.completion if whole else None,
            "cached": self.cached,
            "total": self.prompt + self.completion if whole else None,
        }
        measured = {
            "calls": self.calls,
            "attempts": self.attempts,
            "tokens": tokens,
            "calls_without_tokens": self.unreported,
            "seconds": round(self.seconds, 3),
        }
        cost = self.cost
        return {"measured": measured, "declared": {"price_usd": None if cost is None else round(cost, 6)}}

    def _stop(self, limit: str, used: str) -> StopRun:
        waiting = f" and waits for {self._open} more" if self._open else ""
        advice = "resume it with a higher limit to go on"
        words = f"the run has used {used}{waiting}, and the next call could exceed {limit}: {advice}"
        return StopRun(words, limit.partition("=")[0])
