"""Checks at the server's start: warnings about settings, and refusal of exposed data."""

import subprocess
from pathlib import Path
from typing import Any

import pytest

from arramon_server.configuration.config import Config
from arramon_server.episodes.splits import read_splits
from arramon_server.errors import BadFile
from arramon_server.per_split import PerSplit
from arramon_server.process.lifecycle import check_secrets, settings_warnings
from tests import tiny
from tests.forked import run

TLS = {"tls_certificate": Path("certificate.pem"), "tls_key": Path("key.pem")}
LIMITED = {"runs_per_day": PerSplit(2)}
NO_LIMIT = {"runs_per_day": PerSplit(0)}
OPEN_ALONE = {"runs_per_day": PerSplit(0, (("tiny", 2),))}
HIDDEN_ALONE = {"runs_per_day": PerSplit(0, (("secret", 2),))}
UNLIMITED = "runs on secret are not limited"
PROXY = {"trust_proxy": True}


@pytest.mark.parametrize(
    ("listen", "settings", "said"),
    [
        ("127.0.0.1:1", {}, []),
        ("unix:/run/a", {}, []),
        ("[::1]:1", {"anonymous": True}, []),
        ("127.0.0.1:1", PROXY, []),  # by default runs on hidden splits are limited
        ("127.0.0.1:1", NO_LIMIT, []),
        ("127.0.0.1:1", PROXY | NO_LIMIT, [UNLIMITED]),
        ("unix:/run/a", PROXY | NO_LIMIT, [UNLIMITED]),
        ("127.0.0.1:1", PROXY | LIMITED, []),
        (
            "127.0.0.1:1",
            PROXY | LIMITED | {"anonymous": True},
            ["anonymous is true: anyone who can reach 127.0.0.1:1 or"],
        ),
        ("10.0.0.1:1", PROXY | NO_LIMIT, [UNLIMITED]),
        ("10.0.0.1:1", TLS | NO_LIMIT, [UNLIMITED]),
        (
            "10.0.0.1:1",
            LIMITED,
            ["clients on other machines cannot play at 10.0.0.1:1, as tokens are accepted over TLS only"],
        ),
        ("10.0.0.1:1", PROXY | OPEN_ALONE, [UNLIMITED]),
        ("10.0.0.1:1", PROXY | HIDDEN_ALONE, []),
        ("0.0.0.0:1", TLS | LIMITED, []),
        ("0.0.0.0:1", PROXY | LIMITED, []),
        (
            "0.0.0.0:1",
            LIMITED,
            ["clients on other machines cannot play at 0.0.0.0:1, as tokens are accepted over TLS only"],
        ),
        ("0.0.0.0:1", {"anonymous": True} | LIMITED, ["anonymous is true: anyone who can reach 0.0.0.0:1 may play"]),
        ("0.0.0.0:1", TLS | NO_LIMIT, [UNLIMITED]),
        ("0.0.0.0:1", TLS | NO_LIMIT | {"runs_in_all": PerSplit(9)}, []),
    ],
)
def test_probably_unintended_settings_cause_warnings(
    tmp_path: Path, listen: str, settings: dict[str, Any], said: list[str]
) -> None:
    splits = {split.name: split for split in (tiny.write(tmp_path), tiny.write(tmp_path, "secret", hidden=True))}
    found = list(settings_warnings(Config(data=tmp_path, listen=listen, **settings), splits))
    assert [warning[: len(start)] for warning, start in zip(found, said, strict=True)] == said


@pytest.mark.parametrize(
    ("name", "mode", "expected"),
    [
        ("secret", 0o644, "600"),
        ("secret", 0o640, "600"),
        ("secret", 0o604, "600"),
        ("splits/hidden", 0o755, "700"),
        ("splits/hidden", 0o750, "700"),
        ("splits/hidden", 0o701, "700"),
    ],
)
def test_hidden_data_readable_by_others_is_refused(tmp_path: Path, name: str, mode: int, expected: str) -> None:
    data = tmp_path / "a folder"
    tiny.write(data)
    tiny.write(data, "hidden", hidden=True)
    (data / "secret").write_text("00" * 32)
    (data / "secret").chmod(0o600)
    config, splits = Config(data=data), read_splits(data)
    check_secrets(config, splits)  # as the data folder is made
    (data / name).chmod(mode)
    with pytest.raises(BadFile) as caught:
        check_secrets(config, splits)
    problem = f"has mode {mode:o}, so that others can read it; expected {expected} (`chmod {expected} '{data / name}'`)"
    assert str(caught.value) == f"{data / name}: {problem}"
    subprocess.run(str(caught.value).split("`")[1], shell=True, check=True)
    check_secrets(config, splits)


def test_serve_refuses_exposed_data_before_creating_the_journal(tmp_path: Path) -> None:
    tiny.write(tmp_path, "hidden", hidden=True)
    (tmp_path / "splits" / "hidden").chmod(0o755)
    done = run("serve", "--data", tmp_path, "--listen", "127.0.0.1:0")
    assert (done.returncode, "has mode 755" in done.stderr) == (1, True)
    assert not (tmp_path / "journal.db").exists()
