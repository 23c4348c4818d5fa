"""The host's secret: creation, reuse, and errors."""

import stat
from pathlib import Path

import pytest

from arramon_server.episodes.split_secrets import host_secret
from arramon_server.errors import BadFile, StorageError


def test_secret_is_created_once_with_private_permissions(tmp_path: Path) -> None:
    data = tmp_path / "new"
    secret = host_secret(data)

    assert len(bytes.fromhex(secret)) == 32
    assert stat.S_IMODE((data / "secret").stat().st_mode) == 0o600
    assert host_secret(data) == secret
    assert [path.name for path in data.iterdir()] == ["secret"]
    assert host_secret(tmp_path / "other") != secret


def test_secret_readable_by_others_is_refused(tmp_path: Path) -> None:
    host_secret(tmp_path)
    (tmp_path / "secret").chmod(0o640)

    with pytest.raises(BadFile, match="others can read it; expected 600"):
        host_secret(tmp_path)


@pytest.mark.parametrize("text", ["", "swordfish", "0" * 63, "g" * 64])
def test_malformed_secret_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "secret").write_text(text)
    (tmp_path / "secret").chmod(0o600)

    with pytest.raises(BadFile, match="64 hexadecimal digits"):
        host_secret(tmp_path)


def test_unusable_data_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")

    with pytest.raises(StorageError, match="file"):
        host_secret(tmp_path / "file" / "data")
