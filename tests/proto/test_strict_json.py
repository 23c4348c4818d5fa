"""Reading of JSON from strangers."""

import pytest

from arramon.strict_json import DEEPEST, NotJsonError, read_json


@pytest.mark.parametrize(("text", "content"), [
    ('{"a": [1, 2.5, null, "\\u0928"]}', {"a": [1, 2.5, None, "न"]}),
    (b"\xef\xbb\xbf[true]", [True]),
    ("[" * DEEPEST + "]" * DEEPEST, None),
    ("[]", []),
])  # fmt: skip
def test_json_is_read(text: str | bytes, content: object) -> None:
    found = read_json(text)
    assert content is None or found == content


@pytest.mark.parametrize(("text", "said"), [
    ("", "is not JSON, or was truncated"),
    ('{"a": ', "is not JSON, or was truncated"),
    (b"\xff\xfe\xff", "is not JSON, or was truncated"),
    ("9" * 5000, "is not JSON, or was truncated"),
    ("[" * 200_000, "is nested more than 64 levels deep"),
    ('{"a":' * 200_000, "is nested more than 64 levels deep"),
    ("[" * 200_000 + "]" * 200_000, "is nested more than 64 levels deep"),
    ("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1), "is nested more than 64 levels deep"),
    ('{"a": [NaN]}', "has the number NaN, which JSON does not have"),
    ("[-Infinity]", "has the number -Infinity, which JSON does not have"),
    ("[1e999]", "has a number that is too large"),
])  # fmt: skip
def test_other_texts_are_refused_with_the_reason(text: str | bytes, said: str) -> None:
    with pytest.raises(NotJsonError) as caught:
        read_json(text)
    assert str(caught.value) == said
