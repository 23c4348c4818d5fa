"""What the server says of settings that a host may not have meant."""

from pathlib import Path
from typing import Any

import pytest

from server.config import Config
from server.serving import doubts
from tests import tiny

TLS = {"tls_certificate": Path("certificate.pem"), "tls_key": Path("key.pem")}
LIMITED = {"runs_per_day": 2}


@pytest.mark.parametrize(
    ("listen", "settings", "said"),
    [
        ("127.0.0.1:1", {"runs_per_day": 0}, []),
        ("10.0.0.1:1", {"runs_per_day": 0}, []),
        ("0.0.0.0:1", TLS | LIMITED, []),
        ("0.0.0.0:1", {"trust_proxy": True} | LIMITED, []),
        ("0.0.0.0:1", LIMITED, ["nobody elsewhere can play at 0.0.0.0:1, as tokens are taken over TLS only"]),
        ("0.0.0.0:1", {"anonymous": True} | LIMITED, ["anonymous is true: whoever can reach 0.0.0.0:1 may play"]),
        ("0.0.0.0:1", TLS | {"runs_per_day": 0}, ["the settings do not limit runs on secret"]),
        ("0.0.0.0:1", TLS | {"runs_per_day": 0, "runs_in_all": 9}, []),
    ],
)
def test_what_a_host_may_not_have_meant_is_said(
    tmp_path: Path, listen: str, settings: dict[str, Any], said: list[str]
) -> None:
    splits = {split.name: split for split in (tiny.write(tmp_path), tiny.write(tmp_path, "secret", hidden=True))}
    found = list(doubts(Config(data=tmp_path, listen=listen, **settings), splits))
    assert [doubt[: len(start)] for doubt, start in zip(found, said, strict=True)] == said
