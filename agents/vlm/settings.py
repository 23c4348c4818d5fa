"""Settings of the agent, checked, and the part of them that a run records."""

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from arramon_client.errors import AgentLoadError

DEFAULT_ENDPOINT = "https://api.openai.com/v1"

NO_KEY = "none"
"""Sent in place of a key to an endpoint of one's own, if there is none."""

CHOICES = {
    "answers": ("schema", "object", "plain", "tools"),
    "image_format": ("png", "jpeg"),
    "detail": ("auto", "low", "high"),
    "sight": ("check", "mark", "skip"),
}
"""Settings that are one of several words."""

RANGES: Mapping[str, tuple[type, float, float]] = {
    "plan": (int, 1, 50),
    "window": (int, 0, 100),
    "image_size": (int, 0, 2048),
    "temperature": (float, 0, 2),
    "seed": (int, 0, 2**31 - 1),
    "reply_tokens": (int, 1, 1_000_000),
    "timeout": (float, 0.1, 3600),
    "attempts": (int, 1, 100),
    "concurrency": (int, 1, 1024),
    "max_calls": (int, 1, 1e12),
    "max_tokens": (int, 1, 1e15),
    "max_cost": (float, 0, 1e9),
}
"""Settings that are numbers: their type, smallest and largest value."""

OPTIONAL = ("temperature", "seed", "max_calls", "max_tokens", "max_cost", "extra", "prompts", "prices", "trace")
"""Settings that may be None."""

PLAYED = (
    "model", "endpoint", "plan", "window", "answers", "images", "image_size", "image_format", "detail", "temperature",
    "seed", "reply_tokens", "extra", "sight",
)  # fmt: skip
"""Settings that may change what is played, so that the run records them."""


@dataclass(frozen=True)
class ModelSettings:
    """The arguments of `make_agent`, checked."""

    model: str
    endpoint: str = DEFAULT_ENDPOINT
    key_variable: str = "OPENAI_API_KEY"
    plan: int = 4
    window: int = 4
    answers: str = "schema"
    images: bool = True
    image_size: int = 0
    image_format: str = "png"
    detail: str = "auto"
    temperature: float | None = None
    seed: int | None = None
    reply_tokens: int = 1024
    extra: Mapping[str, Any] | None = None
    prompts: str | None = None
    sight: str = "check"
    timeout: float = 120.0
    attempts: int = 5
    concurrency: int = 8
    max_calls: int | None = None
    max_tokens: int | None = None
    max_cost: float | None = None
    prices: str | None = None
    trace: str | None = None

    def recorded(self) -> dict[str, str]:
        """Return the settings that the run records, as text: the model, and those that differ from their defaults."""
        defaults = {each.name: each.default for each in fields(self)}
        values = {name: getattr(self, name) for name in PLAYED}
        return {name: _typed(value) for name, value in values.items() if value != defaults[name]}


def read_settings(given: Mapping[str, object]) -> ModelSettings:
    """Return the settings after checking each argument.

    Raises:
        AgentLoadError: if one is wrong; the message names it and what was expected.
    """
    for name, value in given.items():
        if value is None and name in OPTIONAL:
            continue
        if name in CHOICES and value not in CHOICES[name]:
            raise _wrong(name, value, f"one of {', '.join(CHOICES[name])}")
        if name in RANGES:
            _check_number(name, value)
        elif name == "images" and not isinstance(value, bool):
            raise _wrong(name, value, "true or false")
        elif name == "extra" and not isinstance(value, dict):
            raise _wrong(name, value, 'a JSON object, e.g. {"reasoning_effort":"low"}')
        elif name not in ("images", "extra") and not (isinstance(value, str) and value):
            raise _wrong(name, value, "a text that is not empty")
    settings = ModelSettings(**given)  # type: ignore[arg-type]
    _check_endpoint(settings.endpoint)
    if settings.max_cost is not None and settings.prices is None:
        raise AgentLoadError("agents.vlm: max_cost needs prices=FILE, or the cost of a call is unknown")
    return settings


def read_key(settings: ModelSettings) -> str:
    """Return the key from the environment; NO_KEY for an endpoint of one's own that needs none.

    Raises:
        AgentLoadError: if the variable is named or the endpoint is OpenAI's, and the variable is not set, or its value
            cannot be sent.
    """
    name = settings.key_variable
    key = os.environ.get(name, "").strip()
    if not key:
        if settings.endpoint == DEFAULT_ENDPOINT or name != ModelSettings.key_variable:
            raise AgentLoadError(
                f"agents.vlm: no key in the environment variable {name}: set it (export {name}=...), or name another "
                "with --agent-arg key_variable=NAME; a key is never an argument, as arguments are public with the run"
            )
        return NO_KEY
    if not (key.isascii() and key.isprintable()) or " " in key:
        raise AgentLoadError(f"agents.vlm: {name} does not hold a key: expected one word of ASCII characters")
    return key


def check_folder(folder: str | Path) -> Path:
    """Return the trace's folder, after creating it if necessary.

    Raises:
        AgentLoadError: if it cannot be created.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise AgentLoadError(f"agents.vlm: trace={folder} cannot be created: {error.strerror}") from error
    return path


def _check_number(name: str, value: object) -> None:
    kind, low, high = RANGES[name]
    kinds = (int, float) if kind is float else (int,)
    if isinstance(value, bool) or not isinstance(value, kinds) or not low <= value <= high or not math.isfinite(value):
        number = "a number" if kind is float else "a whole number"
        raise _wrong(name, value, f"{number} from {low:g} to {high:g}")


def _check_endpoint(endpoint: str) -> None:
    try:
        parts = urlsplit(endpoint)
        port_is_valid = parts.port is None or parts.port > 0
    except ValueError:
        raise _wrong("endpoint", endpoint, "a URL such as http://localhost:8000/v1") from None
    if parts.scheme not in ("http", "https") or not parts.hostname or not port_is_valid:
        raise _wrong("endpoint", endpoint, "a URL such as http://localhost:8000/v1")
    if parts.username is not None or parts.password is not None or parts.query or parts.fragment:
        raise AgentLoadError(
            "agents.vlm: endpoint must hold neither a password nor a query, as arguments are public with the run: put "
            "the key into the environment variable that key_variable names"
        )


def _typed(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, separators=(",", ":"), sort_keys=True)


def _wrong(name: str, value: object, expected: str) -> AgentLoadError:
    return AgentLoadError(f"agents.vlm: {name} is {str(value)[:100]!r}; expected {expected}")
