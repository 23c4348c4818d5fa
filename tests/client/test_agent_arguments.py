"""Arguments for an agent: their syntax, and the parsing of values."""

from typing import Any

import pytest

from arramon_client.errors import AgentLoadError, UsageError
from arramon_client.plugin.arguments import parse_arguments, parse_value, recorded_arguments


@pytest.mark.parametrize(("typed", "value"), [
    ("4", 4), ("-0.5", -0.5), ("1e-3", 0.001), ("true", True), ("false", False), ("null", None),
    ("[1, 2]", [1, 2]), ('{"a": 1}', {"a": 1}), ('"4"', "4"), (" 4", 4),
    ("w.pt", "w.pt"), ("", ""), ("True", "True"), ("None", "None"), ("04", "04"), ("0x10", "0x10"), ("1_000", "1_000"),
    ("nan", "nan"), ("NaN", "NaN"), ("-Infinity", "-Infinity"), ("1e999", "1e999"), ("[NaN]", "[NaN]"),
    ("[1, 2", "[1, 2"), ("a=b", "a=b"), ("लाल", "लाल"), ("[" * 190, "[" * 190),
])  # fmt: skip
def test_argument_values_are_parsed_as_json_or_text(typed: str, value: object) -> None:
    found = parse_value(typed)
    assert (found, type(found)) == (value, type(value))


def test_arguments_are_kept_as_typed() -> None:
    typed = ["checkpoint=w.pt", "beam=4", "empty=", "rule=a=b"]
    assert parse_arguments(typed) == {"checkpoint": "w.pt", "beam": "4", "empty": "", "rule": "a=b"}


@pytest.mark.parametrize(("typed", "said"), [
    (["beam"], "--agent-arg 'beam' is not NAME=VALUE"),
    (["=4"], "--agent-arg '=4' is not NAME=VALUE"),
    (["be-am=4"], "is not NAME=VALUE with an ASCII identifier"),
    (["किरण=4"], "is not NAME=VALUE with an ASCII identifier"),
    (["beam=4", "beam=5"], "--agent-arg beam is given twice: '4' and '5'"),
    (["a=" + "x" * 201], "a value of 201 characters; at most 64 and 200 are allowed"),
    (["a" * 65 + "=1"], "has a name of 65"),
    ([f"a{n}=1" for n in range(17)], "there are 17 --agent-arg"),
    ([f"a{n}=" + "x" * 190 for n in range(6)], "with 1152 characters; at most 16 with 1000"),
    (["a=1\n2"], "expected one line"),
])  # fmt: skip
def test_invalid_arguments_are_refused(typed: list[str], said: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_arguments(typed)
    assert said in str(caught.value)


class Recording:
    def __init__(self, arguments: object) -> None:
        self.recorded_arguments = arguments


def test_an_agent_may_record_other_arguments_than_those_typed() -> None:
    assert recorded_arguments(object(), {"beam": "4"}) == {"beam": "4"}
    assert recorded_arguments(Recording(None), {"beam": "4"}) == {"beam": "4"}
    assert recorded_arguments(Recording({"prompts": "0a1b=="}), {"beam": "4"}) == {"prompts": "0a1b=="}
    assert recorded_arguments(Recording({}), {"beam": "4"}) == {}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["beam=4"], "recorded_arguments are ['beam=4']; expected a mapping"),
        ({"beam": 4}, "recorded_arguments are {'beam': 4}; expected a mapping"),
        ({"be-am": "4"}, "recorded_arguments cannot be recorded: --agent-arg 'be-am=4' is not NAME=VALUE"),
        ({"beam": "x" * 201}, "recorded_arguments cannot be recorded: --agent-arg beam has a name of 4"),
    ],
)
def test_what_an_agent_cannot_record(arguments: object, said: str) -> None:
    with pytest.raises(AgentLoadError) as caught:
        recorded_arguments(Recording(arguments), {})
    assert said in str(caught.value)


def test_argument_limits_equal_the_servers() -> None:
    server: Any = pytest.importorskip(
        "arramon_server.runs.agent_arguments", reason="needs the server's package installed"
    )

    from arramon_client.plugin import arguments as client

    for name in ("MOST_ARGUMENTS", "LONGEST_NAME", "LONGEST_VALUE", "LONGEST_IN_ALL"):
        assert getattr(client, name) == getattr(server, name)
