"""Replies of the model: strictly read, without looking for actions in prose."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.vlm.prompt_texts import Prompts
from arramon_client.agent import Action

ACTIONS = {action.name.lower(): action for action in Action}
"""Actions by their names in replies."""

TOOL = "act"
"""Name of the tool that takes actions."""

CAUSES = ("empty", "json", "fields", "action", "truncated", "oversize", "tool", "refused")
"""Why a reply cannot be used: it is empty, is not JSON, has other fields, names another action, was cut off at its
length limit, is larger than is read, is not one call of the tool, or refuses."""

OVERSIZE = "oversize"
"""`Reply.finish` of a response that is too large to be read."""


class UnusableReplyError(Exception):
    """A reply that holds no valid actions.

    Attributes:
        cause: one of CAUSES.
    """

    def __init__(self, cause: str) -> None:
        super().__init__(cause)
        self.cause = cause


@dataclass(frozen=True)
class Reply:
    """A reply of the endpoint that is a chat completion.

    Attributes:
        text: the message's content; empty if there is none.
        calls: names and arguments (JSON) of the called tools, in order.
        call_ids: ids of these calls.
        finish: why the reply ended, as the endpoint said: "stop", "length", ...
        refused: whether the model or a filter refused.
    """

    text: str
    calls: tuple[tuple[str, str], ...] = ()
    call_ids: tuple[str, ...] = ()
    finish: str = ""
    refused: bool = False


@dataclass(frozen=True)
class ModelDecision:
    """What a usable reply decides.

    Attributes:
        thought: the model's words; may be empty.
        plan: at least one action.
    """

    thought: str
    plan: tuple[Action, ...]


def reply_of(content: object) -> Reply | None:
    """Return the first choice of a chat completion; None if the content is none."""
    choices = content.get("choices") if isinstance(content, dict) else None
    choice = choices[0] if isinstance(choices, list) and choices else None
    message = choice.get("message") if isinstance(choice, dict) else None
    if not isinstance(choice, dict) or not isinstance(message, dict):
        return None
    text, finish, refusal = message.get("content"), choice.get("finish_reason"), message.get("refusal")
    if isinstance(text, list):  # Parts, as some endpoints answer.
        text = "".join(part["text"] for part in text if isinstance(part, dict) and isinstance(part.get("text"), str))
    calls, ids = [], []
    listed = message.get("tool_calls") or []
    if not isinstance(listed, list):
        return None
    for number, call in enumerate(listed):
        function = call.get("function") if isinstance(call, dict) else None
        if not isinstance(call, dict) or not isinstance(function, dict):
            return None
        name, arguments, call_id = function.get("name"), function.get("arguments"), call.get("id")
        calls.append((_text(name), _text(arguments)))
        ids.append(call_id if isinstance(call_id, str) and call_id else f"call_{number}")
    return Reply(
        _text(text),
        tuple(calls),
        tuple(ids),
        finish if isinstance(finish, str) else "",
        isinstance(refusal, str) and bool(refusal),
    )


def _text(content: object) -> str:
    return whole_characters(content) if isinstance(content, str) else ""


def read_fields(reply: Reply, tool: str | None) -> Mapping[str, Any]:
    """Return the JSON object of a reply.

    Args:
        reply: the reply.
        tool: name of the tool that it must call once; None if the content must be the object.

    Raises:
        UnusableReplyError: if there is no such object.
    """
    if reply.refused or reply.finish == "content_filter":
        raise UnusableReplyError("refused")
    if reply.finish == OVERSIZE:
        raise UnusableReplyError("oversize")
    if reply.finish == "length":
        raise UnusableReplyError("truncated")
    if tool is None:
        text = reply.text
        if reply.calls:
            raise UnusableReplyError("tool")
    else:
        if not reply.calls and not reply.text.strip():
            raise UnusableReplyError("empty")
        if len(reply.calls) != 1 or reply.calls[0][0] != tool:
            raise UnusableReplyError("tool")
        text = reply.calls[0][1]
    if not text.strip():
        raise UnusableReplyError("empty")
    try:
        content = read_json(text)
    except NotJsonError:
        raise UnusableReplyError("json") from None
    if not isinstance(content, dict):
        raise UnusableReplyError("json")
    return content


def read_decision(reply: Reply, answers: str, most: int) -> ModelDecision:
    """Return what a reply decides; actions beyond the `most` that were asked for are dropped.

    Raises:
        UnusableReplyError: if it cannot be used.
    """
    fields = read_fields(reply, TOOL if answers == "tools" else None)
    actions, thought = fields.get("actions"), fields.get("thought", "")
    if not isinstance(actions, list) or not actions or not isinstance(thought, str) or fields.keys() - _FIELDS:
        raise UnusableReplyError("fields")
    if not all(isinstance(name, str) and name in ACTIONS for name in actions):
        raise UnusableReplyError("action")
    return ModelDecision(whole_characters(thought), tuple(ACTIONS[name] for name in actions[:most]))


def whole_characters(text: str) -> str:
    """Return a text that UTF-8 can hold: JSON may name halves of characters, which become question marks."""
    return text.encode("utf-8", "replace").decode()


_FIELDS = {"thought", "actions"}


def schema(prompts: Prompts) -> dict[str, Any]:
    """Return the JSON Schema of a decision, in the subset that strict modes accept."""
    action = {"type": "string", "enum": list(ACTIONS)}
    return {
        "type": "object",
        "properties": {
            "thought": {"type": "string", "description": prompts.text("answer.thought")},
            "actions": {"type": "array", "items": action, "description": prompts.text("answer.actions")},
        },
        "required": ["thought", "actions"],
        "additionalProperties": False,
    }


def answer_form(answers: str, name: str, description: str, form: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a request that ask for an answer in a form.

    Args:
        answers: the setting.
        name: of the schema or the tool.
        description: of the tool.
        form: JSON Schema of the object.
    """
    if answers == "schema":
        named = {"name": name, "strict": True, "schema": form}
        return {"response_format": {"type": "json_schema", "json_schema": named}}
    if answers == "object":
        return {"response_format": {"type": "json_object"}}
    if answers == "tools":
        function = {"name": name, "description": description, "parameters": form}
        choice = {"type": "function", "function": {"name": name}}
        return {"tools": [{"type": "function", "function": function}], "tool_choice": choice}
    return {}


def written(decision: ModelDecision) -> str:
    """Return a decision as the JSON that a model would answer, for the history of a restored episode."""
    fields = {"thought": decision.thought, "actions": [action.name.lower() for action in decision.plan]}
    return json.dumps(fields, ensure_ascii=False)
