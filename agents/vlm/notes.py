"""Notes of a step: what the model said and what it cost, short enough to be stored with the step."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.vlm.records import PaidReply
from arramon_agents.vlm.replies import ACTIONS, ModelDecision
from arramon_agents.vlm.usage import Price

LONGEST = 2048
"""Bytes of UTF-8 that a note may have as compact JSON."""

NOOP = ModelDecision("", ())
"""What `read` returns for a step that was taken in place of an unusable reply."""


def write(
    decision: ModelDecision | None, cause: str, replies: Sequence[PaidReply], price: Price | None, sight: str
) -> dict[str, Any]:
    """Return the note of the step that begins a plan.

    Args:
        decision: what the model decided; None for a no-op.
        cause: why the reply cannot be used; empty if it can.
        replies: the replies behind the decision.
        price: prices of the model; None if unknown.
        sight: result of the sight check, noted unless it was passed or not needed.
    """
    note: dict[str, Any] = {"plan": [action.name.lower() for action in decision.plan] if decision else []}
    if cause:
        note["noop"] = cause
    tokens = [paid.tokens for paid in replies if paid.tokens is not None]
    if len(tokens) == len(replies):
        note["tokens"] = [sum(each.prompt for each in tokens), sum(each.completion for each in tokens)]
        if price is not None:
            note["usd"] = round(sum(map(price.cost, tokens)), 6)
    note["calls"] = len(replies)
    if sight in ("blind", "skipped"):
        note["sight"] = sight
    thought = decision.thought if decision else ""
    note["thought"] = thought
    while thought and len(_compact(note)) > LONGEST:
        thought = thought[: len(thought) * 3 // 4]
        note["thought"] = thought + "..."
    return note


def read(note: str | None, most: int) -> ModelDecision | None:
    """Return the decision that a note holds; NOOP for a no-op's; None if it is no note of this agent.

    Args:
        note: the note as stored; None if there is none.
        most: the most actions of a plan.
    """
    try:
        content = read_json(note) if note else None
    except NotJsonError:
        return None
    if not isinstance(content, dict):
        return None
    if "noop" in content:
        return NOOP
    plan, thought = content.get("plan"), content.get("thought")
    if not isinstance(plan, list) or not plan or not isinstance(thought, str):
        return None
    if not all(isinstance(name, str) and name in ACTIONS for name in plan):
        return None
    return ModelDecision(thought, tuple(ACTIONS[name] for name in plan[:most]))


def _compact(note: Mapping[str, Any]) -> bytes:
    return json.dumps(note, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")
