"""Messages of the play page: what is accepted, and how everything else is refused."""

import json

import pytest

from arramon_server.errors import BadInput
from arramon_server.web.play.requests import (
    AskScores,
    GiveUp,
    Hello,
    Key,
    Look,
    NewRun,
    Publish,
    read_hello,
    read_request,
)

PLAYER, RUN = "0f" * 8, "2e" * 16
HELLO = {"type": "hello", "player": PLAYER, "size": 224}
NEW = {"split": "tiny", "language": "hi", "episodes": 2}


def test_first_messages() -> None:
    assert read_hello(json.dumps({**HELLO, "run": RUN, "token": "t"})) == Hello(PLAYER, "t", 224, RUN)
    new = NewRun("tiny", "hi", 2, "", (RUN,))
    assert read_hello(json.dumps({**HELLO, "new": {**NEW, "earlier": [RUN]}})) == Hello(PLAYER, "", 224, new)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ({"type": "key", "episode": "1", "step": 3, "action": 0}, Key("1", 3, 0)),
        ({"type": "look", "episode": "1", "step": 3, "degrees": 330}, Look("1", 3, 330)),
        ({"type": "give_up", "episode": "1"}, GiveUp("1")),
        ({"type": "scores"}, AskScores("")),
        ({"type": "publish"}, Publish()),
        ({"type": "scores", "episode": "1"}, AskScores("1")),
    ],
)
def test_further_messages(text: dict[str, object], expected: object) -> None:
    assert read_request(json.dumps(text)) == expected


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "a message is not JSON, or was truncated; expected a JSON object"),
        ("[1]", "a message is no JSON object"),
        (
            '{"type": "fly"}',
            "a message is of type 'fly', expected 'key', 'look', 'give_up', 'next', 'scores' or 'publish'",
        ),
        (
            '{"type": ["key"]}',
            "a message is of type \"['key']\", expected 'key', 'look', 'give_up', 'next', 'scores' or 'publish'",
        ),
        ('{"type": "key", "step": 1, "action": 0}', "episode is missing, expected a text"),
        ('{"type": "key", "episode": 5, "step": 1, "action": 0}', "episode is no text, expected a text"),
        ('{"type": "key", "episode": "5", "action": 0}', "step is missing, expected a whole number from 0 to 1000000"),
        ('{"type": "key", "episode": "5", "step": -1, "action": 0}', "step is '-1', expected"),
        ('{"type": "key", "episode": "5", "step": true, "action": 0}', "step is 'True', expected"),
        ('{"type": "key", "episode": "5", "step": 1.0, "action": 0}', "step is '1.0', expected"),
        (
            '{"type": "key", "episode": "5", "step": 1, "action": 4}',
            "action is '4', expected a whole number from 0 to 3",
        ),
        ('{"type": "look", "episode": "5", "step": 1, "degrees": 45}', "degrees is 45, expected a multiple of 30"),
        ('{"type": "look", "episode": "5", "step": 1, "degrees": 360}', "degrees is '360', expected a whole number"),
        ('{"type": "key", "episode": "5", "step": NaN, "action": 4}', "has the number NaN, which JSON does not have"),
        (json.dumps({"type": "give_up", "episode": "x" * 201}), "episode has 201 characters; at most 200 are allowed"),
        ("[" * 100 + "]" * 100, "is nested more than 4 levels deep"),
        ('"' + "x" * 9000 + '"', "a message has 9002 characters; at most 8192 are allowed"),
    ],
)
def test_malformed_messages_are_refused(text: str, problem: str) -> None:
    with pytest.raises(BadInput) as refused:
        read_request(text)
    assert problem in str(refused.value)


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"type": "key"}, "the first message is of type 'key', expected 'hello'"),
        ({"player": "me"}, "player is 'me', expected 16 to 64 hexadecimal digits"),
        ({}, "the first message has `run` and `new`, or neither; expected one of them"),
        ({"run": RUN, "new": NEW}, "the first message has `run` and `new`, or neither; expected one of them"),
        ({"run": "../etc"}, "run is '../etc', expected 32 hexadecimal digits"),
        ({"new": []}, "new is no object, expected one with split and language"),
        ({"new": {**NEW, "earlier": ["x"]}}, "earlier has something that is no id of a run"),
        ({"new": {**NEW, "earlier": [RUN] * 101}}, "earlier is no list of at most 100 ids of runs"),
        ({"new": {**NEW, "episodes": 101}}, "episodes is '101', expected a whole number from 0 to 100"),
        ({"run": RUN, "practice": 1}, "practice is neither true nor false"),
        ({"size": "224", "run": RUN}, "size is '224', expected a whole number"),
    ],
)
def test_malformed_first_messages_are_refused(changed: dict[str, object], problem: str) -> None:
    with pytest.raises(BadInput) as refused:
        read_hello(json.dumps({**HELLO, **changed}))
    assert problem in str(refused.value)
