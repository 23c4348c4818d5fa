"""Records of the trace: what a call asked and got, and how a restored episode finds it again."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from arramon_agents.vlm.endpoint import Completion, FailedCallError
from arramon_agents.vlm.messages import Conversation
from arramon_agents.vlm.replies import Reply
from arramon_agents.vlm.usage import Tokens, tokens_of

Key = tuple[str, int, str]
"""Episode, step and prompt hash of a call."""


@dataclass(frozen=True)
class PaidReply:
    """A reply that was paid for, live or read from the trace.

    Attributes:
        prompt: hash of the conversation.
        reply: the reply.
        tokens: as the endpoint reported them; None if it did not.
        attempts: attempts of the call.
        seconds: duration of the last one.
    """

    prompt: str
    reply: Reply
    tokens: Tokens | None
    attempts: int
    seconds: float


def call_record(
    purpose: str, key: Key, conversation: Conversation, completion: Completion, cause: str
) -> dict[str, Any]:
    """Return the record of an answered call.

    Args:
        purpose: "act", "again" (after an unusable reply) or "sight".
        key: episode, step and prompt hash.
        conversation: what was sent.
        completion: what came.
        cause: why the reply cannot be used; empty if it can.
    """
    reply, tokens = completion.reply, completion.tokens
    return {
        **_question("call", purpose, key, conversation),
        "answer": {"text": reply.text, "calls": [list(call) for call in reply.calls], "ids": list(reply.call_ids)},
        "finish": reply.finish,
        "refused": reply.refused,
        "unusable": cause,
        "tokens": tokens.as_json() if tokens is not None else None,
        "seconds": round(completion.seconds, 3),
        "attempts": len(completion.failures) + 1,
        "failures": list(completion.failures),
        "model": completion.model,
    }


def failure_record(purpose: str, key: Key, conversation: Conversation, failed: FailedCallError) -> dict[str, Any]:
    """Return the record of a call that got no answer."""
    return {
        **_question("failure", purpose, key, conversation),
        "attempts": len(failed.failures),
        "failures": list(failed.failures),
        "error": str(failed),
    }


def failed_attempts(record: Mapping[str, Any]) -> int:
    """Return the attempts of a call that got no answer; 0 for other records."""
    attempts = record.get("attempts", 1)
    return attempts if record.get("kind") == "failure" and isinstance(attempts, int) else 0


def paid_reply(record: Mapping[str, Any]) -> PaidReply | None:
    """Return the reply that a record holds; None if the record is of another kind, or is damaged."""
    answer = record.get("answer")
    if record.get("kind") != "call" or not isinstance(answer, dict) or not isinstance(record.get("prompt"), str):
        return None
    calls = answer.get("calls", [])
    try:
        reply = Reply(
            str(answer.get("text", "")),
            tuple((str(name), str(arguments)) for name, arguments in calls),
            tuple(map(str, answer.get("ids", []))),
            str(record.get("finish", "")),
            record.get("refused") is True,
        )
        attempts, seconds = int(record.get("attempts", 1)), float(record.get("seconds", 0.0))
    except (TypeError, ValueError):
        return None
    return PaidReply(record["prompt"], reply, tokens_of(record.get("tokens")), attempts, seconds)


class PaidReplies:
    """Replies of a run that were paid for, by episode and step.

    Args:
        records: of the trace, in order.
    """

    def __init__(self, records: Iterable[Mapping[str, Any]]) -> None:
        self._replies: dict[tuple[str, int], list[PaidReply]] = {}
        for record in records:
            paid = paid_reply(record)
            if paid is not None and isinstance(record.get("step"), int):
                self.add(str(record.get("episode")), record["step"], paid)

    def add(self, episode_id: str, step: int, paid: PaidReply) -> None:
        """Add a reply."""
        self._replies.setdefault((episode_id, step), []).append(paid)

    def at(self, episode_id: str, step: int) -> tuple[PaidReply, ...]:
        """Return all replies before a step, in order."""
        return tuple(self._replies.get((episode_id, step), ()))

    def find(self, episode_id: str, step: int, prompt: str) -> PaidReply | None:
        """Return the reply to a conversation; None if it was never paid."""
        return next((paid for paid in self.at(episode_id, step) if paid.prompt == prompt), None)


def _question(kind: str, purpose: str, key: Key, conversation: Conversation) -> dict[str, Any]:
    """Return what the records of calls with and without an answer have in common."""
    episode_id, step, prompt = key
    return {
        "kind": kind,
        "time": round(time.time(), 3),
        "purpose": purpose,
        "episode": episode_id,
        "step": step,
        "prompt": prompt,
        "messages": list(conversation.traced),
    }
