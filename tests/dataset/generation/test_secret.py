import stat
from pathlib import Path

import pytest

from server.dataset.generation.secret import host_secret
from server.errors import BadFile, StorageError


def test_it_is_made_once_and_its_owners_alone(tmp_path: Path) -> None:
    data = tmp_path / "new"
    secret = host_secret(data)

    assert len(bytes.fromhex(secret)) == 32
    assert stat.S_IMODE((data / "secret").stat().st_mode) == 0o600
    assert host_secret(data) == secret
    assert [path.name for path in data.iterdir()] == ["secret"]
    assert host_secret(tmp_path / "other") != secret


def test_one_that_others_can_read_is_refused(tmp_path: Path) -> None:
    host_secret(tmp_path)
    (tmp_path / "secret").chmod(0o640)

    with pytest.raises(BadFile, match="others can read it; expected 600"):
        host_secret(tmp_path)


@pytest.mark.parametrize("text", ["", "swordfish", "0" * 63, "g" * 64])
def test_what_is_no_secret_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "secret").write_text(text)
    (tmp_path / "secret").chmod(0o600)

    with pytest.raises(BadFile, match="64 hexadecimal digits"):
        host_secret(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")

    with pytest.raises(StorageError, match="file"):
        host_secret(tmp_path / "file" / "data")
