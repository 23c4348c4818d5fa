"""Wrong options of `Run.create` and `Run.resume`: named before a server is reached."""

import re
from pathlib import Path
from typing import Any

import pytest

from arramon_client import Run, UsageError

AWAY = "unix:/nonexistent/socket"


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("language", 5, "language is 5, expected text"),
        ("agent", None, "agent is None, expected text"),
        ("server", "", "server is '', expected an address, `host:port` or `unix:/path`"),
        ("data", 5, "data is 5, expected a path"),
        ("tls", "yes", "tls is 'yes', expected True or False"),
        ("notify", "print", "notify is 'print', expected a function with one parameter"),
        ("parallel", 0, "parallel is 0, expected a whole number from 1"),
        ("parallel", "8", "parallel is '8', expected a whole number from 1"),
        ("parallel", True, "parallel is True, expected a whole number from 1"),
        ("encoding", "png", "encoding is 'png', expected one of shared, raw, zstd, jpeg"),
        ("encoding", [], "encoding is [], expected one of shared, raw, zstd, jpeg"),
        ("jpeg_quality", 0, "jpeg_quality is 0, expected a whole number from 1 to 100"),
        ("jpeg_quality", 101, "jpeg_quality is 101, expected a whole number from 1 to 100"),
        ("image_size", 0, "image_size is 0, expected a number of pixels"),
        ("patience", -1, "patience is -1, expected a number of seconds from 0"),
        ("patience", float("nan"), "patience is nan, expected a number of seconds from 0"),
        ("split", 5, "split is 5, expected the name of a split"),
        ("sensors", "rgb", "sensors is 'rgb', expected a sequence of names, e.g. (\"rgb\",), or () for none"),
        ("sensors", None, 'sensors is None, expected a sequence of names, e.g. ("rgb",), or () for none'),
        ("episodes", -1, "episodes is -1, expected a whole number from 0"),
        ("episodes", 1.5, "episodes is 1.5, expected a whole number from 0"),
        ("episodes", 2**31, "episodes is 2147483648, expected a whole number from 0"),
        ("episode_ids", "55120", "episode_ids is '55120', expected a sequence of ids, e.g. (\"55120\",)"),
        ("episode_ids", [55120], 'episode_ids is [55120], expected a sequence of ids, e.g. ("55120",)'),
        ("participant", 5, "participant is 5, expected text"),
        ("agent_arguments", ["beam=4"], "agent_arguments is ['beam=4'], expected a mapping of names to values"),
        ("code", "https://e.org", "code is 'https://e.org', expected a mapping with some of url, commit, image"),
        ("code", {"repo": "x"}, "code is {'repo': 'x'}, expected a mapping with some of url, commit, image"),
    ],
)
def test_a_wrong_option_is_named(option: str, value: Any, expected: str) -> None:
    options: Any = {"server": AWAY, "language": "en", "agent": "mine", option: value}
    with pytest.raises(UsageError, match=f"^{re.escape(expected)}$"):
        Run.create(**options)


def test_a_wrong_token_is_not_shown() -> None:
    options: Any = {"token": b"secret"}
    with pytest.raises(UsageError, match=r"^token is of type bytes, expected text$"):
        Run.list(server=AWAY, **options)


@pytest.mark.parametrize("run_id", [None, 5, b"1f" * 16, "1f", "1f" * 16 + "\n"])
def test_a_wrong_run_is_named(run_id: Any, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is not the id of a run, expected 32 hexadecimal digits"):
        Run.resume(run_id, data=tmp_path)
