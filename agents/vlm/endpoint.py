"""Calls of an OpenAI-compatible endpoint: concurrency, time limits, size limits, and retries by cause."""

import asyncio
import random
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from typing import Any

import httpx2
import openai

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.vlm.replies import OVERSIZE, Reply, reply_of
from arramon_agents.vlm.settings import NO_KEY, ModelSettings
from arramon_agents.vlm.usage import Tokens, tokens_of
from arramon_client.errors import AgentError, StopRun

LARGEST_REPLY = 2**20
"""Size limit of a response's body in bytes; a longer one is not read further."""

FIRST_PAUSE, LONGEST_PAUSE = 1.0, 60.0
"""Seconds before the second attempt of a call, doubled for each further one, and their limit."""

SHORTEST_WAIT = 1.0
"""The shortest time for which a call waits if its endpoint names one, in seconds: one that names 0 is not asked without
end."""

LONGEST_WAIT = 600.0
"""The longest time that an endpoint may ask a call to wait, in seconds over all attempts; the run stops if it asks for
more. Attempts after which it names a time are not counted otherwise."""

SHOWN = 200
"""Characters of an endpoint's own message that are shown."""

SHORTEST_KEY = 8
"""Characters of a key that is removed from texts; shorter ones, such as "none", are words of their own."""

TEMPORARY = (408, 409, 425, 429)
"""HTTP statuses below 500 after which a call is tried again."""


@dataclass(frozen=True)
class Completion:
    """An answered call.

    Attributes:
        reply: the model's reply.
        tokens: as the endpoint reports them; None if it does not.
        seconds: duration of the last attempt.
        failures: causes of the failed attempts before, in order.
        model: name of the model, as the endpoint reports it.
    """

    reply: Reply
    tokens: Tokens | None
    seconds: float
    failures: tuple[str, ...] = ()
    model: str = ""


class FailedCallError(Exception):
    """A call got no answer.

    Attributes:
        error: what to raise to the client: a StopRun or an AgentError.
        failures: causes of its attempts, in order.
    """

    def __init__(self, error: StopRun | AgentError, failures: Sequence[str]) -> None:
        super().__init__(str(error))
        self.error, self.failures = error, tuple(failures)


class _FailedAttemptError(Exception):
    """An attempt failed.

    Attributes:
        cause: such as "429" or "timeout".
        words: what happened, for the participant; without the key.
        final: whether another attempt cannot help.
        pause: seconds that the endpoint asks to wait; None if it does not.
        lasting: whether the endpoint, not this call, is at fault, so that the run should stop after the last attempt.
    """

    def __init__(
        self, cause: str, words: str, *, final: bool = False, pause: float | None = None, lasting: bool = False
    ) -> None:
        super().__init__(words)
        self.cause, self.words, self.final, self.pause, self.lasting = cause, words, final, pause, lasting


class Endpoint:
    """An endpoint, as long as an event loop uses it.

    Args:
        settings: the agent's settings.
        key: the key, which is removed from every message.
    """

    def __init__(self, settings: ModelSettings, key: str) -> None:
        self._settings = settings
        self._key = key
        self._slots = asyncio.Semaphore(settings.concurrency)
        self._resume_at = 0.0
        self._client = openai.AsyncOpenAI(
            api_key=key, base_url=settings.endpoint, max_retries=0, timeout=settings.timeout
        )

    async def close(self) -> None:
        """Close the connections."""
        await self._client.close()

    async def call(self, request: Mapping[str, Any]) -> Completion:
        """Return the answer to a chat completion.

        Args:
            request: the fields of the request besides model, seed and the like, which the settings hold.

        Raises:
            FailedCallError: with a StopRun if no further attempt can help (key, model, quota) or the endpoint stays at
                fault, and with an AgentError if every attempt failed with a temporary cause.
        """
        async with self._slots:
            failures: list[_FailedAttemptError] = []
            while True:
                while (pause := self._resume_at - time.monotonic()) > 0:
                    await asyncio.sleep(pause * random.uniform(1.0, 1.2))  # noqa: S311 - spreads attempts, no secret
                began = time.monotonic()
                try:
                    reply, tokens, model = await self._attempt(request)
                except _FailedAttemptError as failed:
                    failures.append(failed)
                    error = _end_of(failures, self._settings.attempts)
                    if error is not None:
                        raise FailedCallError(error, [each.cause for each in failures]) from None
                    await self._pause(failures)
                else:
                    causes = tuple(failed.cause for failed in failures)
                    return Completion(reply, tokens, time.monotonic() - began, causes, model)

    async def _pause(self, failures: Sequence[_FailedAttemptError]) -> None:
        """Wait before the next attempt, after failures in order."""
        failed = failures[-1]
        if failed.pause is not None:  # It concerns all calls, not only this one.
            self._resume_at = max(self._resume_at, time.monotonic() + failed.pause)
            return
        count = sum(each.pause is None for each in failures)
        pause = min(FIRST_PAUSE * 2 ** (count - 1), LONGEST_PAUSE)
        await asyncio.sleep(pause * random.uniform(0.75, 1.25))  # noqa: S311 - spreads attempts, no secret

    async def _attempt(self, request: Mapping[str, Any]) -> tuple[Reply, Tokens | None, str]:
        settings, where = self._settings, f"the endpoint {self._settings.endpoint}"
        try:
            async with (
                asyncio.timeout(settings.timeout),
                self._client.chat.completions.with_streaming_response.create(**self._fields(request)) as response,
            ):
                body = b""
                async for part in response.iter_bytes():
                    body += part
                    if len(body) > LARGEST_REPLY:
                        return Reply("", finish=OVERSIZE), None, ""
        except (TimeoutError, openai.APITimeoutError, httpx2.TimeoutException):
            raise _FailedAttemptError("timeout", f"{where} did not answer in {settings.timeout:g} s") from None
        except openai.APIStatusError as error:
            return self._refused(error)
        except (openai.APIConnectionError, httpx2.HTTPError) as error:
            reason = self._clean(str(error.__cause__ or error)) or type(error).__name__
            raise _FailedAttemptError("connection", f"{where} cannot be reached: {reason}") from None
        return self._read(body)

    def _fields(self, request: Mapping[str, Any]) -> dict[str, Any]:
        settings = self._settings
        own = {"temperature": settings.temperature, "seed": settings.seed}
        fields = {"model": settings.model, **{name: value for name, value in own.items() if value is not None}}
        # Newer models of OpenAI know only the second name, most other servers only the first.
        limit = "max_completion_tokens" if "api.openai.com" in settings.endpoint else "max_tokens"
        extra = dict(settings.extra or {})
        return {**fields, limit: settings.reply_tokens, **request, "extra_body": extra or None}

    def _refused(self, error: openai.APIStatusError) -> tuple[Reply, Tokens | None, str]:
        """Return a refusal if a filter refused the messages; the endpoint has then read and written no tokens.

        Raises:
            _FailedAttemptError: for every other status.
        """
        status, body = error.status_code, error.body if isinstance(error.body, dict) else {}
        code = body.get("code")
        said = self._clean(str(body.get("message") or ""))
        words = f"the endpoint {self._settings.endpoint} answered {status}" + (f": {said}" if said else "")
        if status == 400 and code in ("content_filter", "content_policy_violation"):
            return Reply("", finish="content_filter", refused=True), Tokens(0, 0), ""
        variable = self._settings.key_variable
        if status in (401, 403) and self._key == NO_KEY:
            words += f". No key was sent, as {variable} is not set: put the endpoint's key into it"
        elif status in (401, 403):
            words += f". The key in {variable} is not valid, or has expired or no access"
        elif status == 404:
            model = self._settings.model
            words += f". There is no model {model!r}, or the endpoint's path is wrong (often it ends in /v1)"
        elif status in (400, 422) and self._settings.answers in ("schema", "object", "tools"):
            words += ". If it does not support this form of answers, choose another: --agent-arg answers=plain"
        has_no_credit = status == 429 and code == "insufficient_quota"
        final = has_no_credit or (status < 500 and status not in TEMPORARY)
        raise _FailedAttemptError(str(status), words, final=final, pause=_pause_of(error.response.headers)) from None

    def _read(self, body: bytes) -> tuple[Reply, Tokens | None, str]:
        """Return the reply in the body of a response.

        Raises:
            _FailedAttemptError: if it is not a chat completion.
        """
        where = f"the endpoint {self._settings.endpoint}"
        hint = "check --agent-arg endpoint (its path often ends in /v1)"
        if not body.strip():
            raise _FailedAttemptError("empty body", f"{where} answered with an empty body", lasting=True)
        if body.lstrip().startswith(b"<"):
            raise _FailedAttemptError("html", f"{where} answered with a web page: {hint}", lasting=True)
        try:
            content = read_json(body)
        except NotJsonError as error:
            raise _FailedAttemptError("not json", f"{where} answered with what {error}: {hint}", lasting=True) from None
        reply = reply_of(self._without_key(content))
        if reply is None:
            words = f"{where} answered with JSON that is not a chat completion: {hint}"
            raise _FailedAttemptError("no completion", words, lasting=True)
        model = content.get("model")
        return reply, tokens_of(content.get("usage")), self._clean(model) if isinstance(model, str) else ""

    def _clean(self, text: str) -> str:
        """Return a foreign text in one printable line, shortened, without the key."""
        text = self._without_key(text)
        text = "".join(each if each.isprintable() else " " for each in text)
        return text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."

    def _without_key(self, content: Any) -> Any:
        """Return a JSON value with the key replaced in every text: an endpoint may repeat what was sent to it."""
        if isinstance(content, str):
            return content.replace(self._key, "[key]") if len(self._key) >= SHORTEST_KEY else content
        if isinstance(content, list):
            return [self._without_key(each) for each in content]
        if isinstance(content, dict):
            return {name: self._without_key(each) for name, each in content.items()}
        return content


def _end_of(failures: Sequence[_FailedAttemptError], attempts: int) -> StopRun | AgentError | None:
    """Return the error of a call without further attempts; None if it is to be tried again.

    Args:
        failures: the failed attempts, in order.
        attempts: the setting.
    """
    failed, pauses = failures[-1], [each.pause for each in failures if each.pause is not None]
    if failed.final:
        return StopRun(f"{failed.words}. Settle this, and resume the run")
    if sum(pauses) > LONGEST_WAIT:
        return StopRun(f"{failed.words}; it asks to wait {sum(pauses):.0f} s. Resume the run then")
    if failed.pause is not None or len(failures) - len(pauses) < attempts:
        return None
    causes = ", ".join(each.cause for each in failures)
    words = f"{failed.words}, after {len(failures)} attempts ({causes})"
    return StopRun(words) if failed.lasting else AgentError(words)


def _pause_of(headers: Mapping[str, str]) -> float | None:
    """Return the seconds that an endpoint asks to wait; None if it does not, or not in a known form."""
    for name, unit in (("retry-after-ms", 1000.0), ("retry-after", 1.0)):
        text = headers.get(name)
        if text is None:
            continue
        try:
            seconds = float(text) / unit
        except ValueError:
            try:
                seconds = parsedate_to_datetime(text).timestamp() - time.time()
            except (ValueError, OverflowError):
                continue
        if seconds == seconds and seconds < 1e9:
            return max(SHORTEST_WAIT, seconds)
    return None
