"""Replies are read strictly: JSON or one call of the tool, never actions found in prose."""

import pytest

from arramon_agents.vlm.replies import ModelDecision, Reply, UnusableReplyError, read_decision
from arramon_client.agent import Action

F, L, R, P = Action

GOOD = '{"thought": "a mug", "actions": ["forward", "left"]}'


@pytest.mark.parametrize(
    ("text", "decision"),
    [
        (GOOD, ModelDecision("a mug", (F, L))),
        (f"\n {GOOD} \n", ModelDecision("a mug", (F, L))),
        ('{"actions": ["interact"]}', ModelDecision("", (P,))),
        ('{"actions": ["right","right","right","right","forward"]}', ModelDecision("", (R, R, R))),
    ],
)
def test_usable_texts(text: str, decision: ModelDecision) -> None:
    assert read_decision(Reply(text), "schema", 3) == decision


@pytest.mark.parametrize(
    ("reply", "cause"),
    [
        (Reply(""), "empty"),
        (Reply("  \n"), "empty"),
        (Reply("I go forward."), "json"),
        (Reply(f"Here: {GOOD}"), "json"),
        (Reply(f"```json\n{GOOD}\n```"), "json"),
        (Reply(GOOD * 3), "json"),
        (Reply("[0, 1]"), "json"),
        (Reply('{"actions": [NaN]}'), "json"),
        (Reply("[" * 5000), "json"),
        (Reply('{"action": "forward"}'), "fields"),
        (Reply('{"actions": []}'), "fields"),
        (Reply('{"actions": "forward"}'), "fields"),
        (Reply('{"actions": ["forward"], "thought": 3}'), "fields"),
        (Reply('{"actions": ["forward"], "speed": 3}'), "fields"),
        (Reply('{"actions": ["jump"]}'), "action"),
        (Reply('{"actions": [0]}'), "action"),
        (Reply('{"actions": ["Forward"]}'), "action"),
        (Reply(GOOD, finish="length"), "truncated"),
        (Reply("", finish="oversize"), "oversize"),
        (Reply(GOOD, finish="content_filter"), "refused"),
        (Reply("", refused=True), "refused"),
        (Reply("", (("act", GOOD),)), "tool"),
    ],
)
def test_unusable_texts(reply: Reply, cause: str) -> None:
    with pytest.raises(UnusableReplyError) as caught:
        read_decision(reply, "schema", 3)
    assert caught.value.cause == cause


@pytest.mark.parametrize(
    ("calls", "text", "cause"),
    [
        ((), "", "empty"),
        ((), GOOD, "tool"),
        ((("walk", GOOD),), "", "tool"),
        ((("act", GOOD), ("act", GOOD)), "", "tool"),
        ((("act", ""),), "", "empty"),
        ((("act", "{"),), "", "json"),
    ],
)
def test_unusable_calls(calls: tuple[tuple[str, str], ...], text: str, cause: str) -> None:
    with pytest.raises(UnusableReplyError) as caught:
        read_decision(Reply(text, calls), "tools", 3)
    assert caught.value.cause == cause


def test_a_usable_call() -> None:
    assert read_decision(Reply("Some words.", (("act", GOOD),)), "tools", 3) == ModelDecision("a mug", (F, L))


def test_a_thought_with_half_a_character_can_be_stored() -> None:
    """It is valid JSON, but no Unicode: a note with it would be refused, and the run could not go on."""
    reply = Reply('{"thought": "left \\ud83d", "actions": ["left"]}')
    assert read_decision(reply, "schema", 4).thought == "left ?"
