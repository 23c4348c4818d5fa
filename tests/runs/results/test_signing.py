"""The host's key: created once, private, and the same on all hosts of one journal."""

import stat
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from arramon_server.errors import BadFile, Conflict, StorageError
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage.database import Database

ONE, OTHER = b"\x01" * 32, b"\x02" * 32


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    with closing(Database(database_url)) as database:
        yield database


def test_signing_key_is_created_once_with_private_permissions(tmp_path: Path) -> None:
    path = tmp_path / "new" / "key.pem"
    key = SigningKey(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert SigningKey(path).public == key.public
    assert [each.name for each in path.parent.iterdir()] == ["key.pem"]
    assert SigningKey(tmp_path / "other.pem").public != key.public
    Ed25519PublicKey.from_public_bytes(key.public).verify(key.sign(b"this"), b"this")


def test_concurrent_starts_create_one_signing_key(tmp_path: Path) -> None:
    program = f"import sys; from pathlib import Path; from arramon_server.runs.results.signing import SigningKey; \
sys.stdin.read(); \
print(SigningKey(Path({str(tmp_path / 'key.pem')!r})).public.hex())"
    started = [
        subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    for process in started:  # all wait here, with everything imported
        assert process.stdin is not None
        process.stdin.close()
    keys = set()
    for process in started:
        assert process.stdout is not None
        keys.add(process.stdout.read())
        process.stdout.close()
        assert process.wait(timeout=240) == 0
    assert keys == {SigningKey(tmp_path / "key.pem").public.hex() + "\n"}


def test_signing_key_readable_by_others_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    SigningKey(path)
    path.chmod(0o640)
    with pytest.raises(BadFile, match="has mode 640, so that others can read it; expected 600"):
        SigningKey(path)


PUBLIC = b"-----BEGIN PUBLIC KEY-----\nMCowBQYDK2VwAyEA\n-----END PUBLIC KEY-----\n"


@pytest.mark.parametrize("content", [b"", b"swordfish", b"\xff\xfe", PUBLIC])
def test_a_file_without_a_key_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "key.pem"
    path.write_bytes(content)
    path.chmod(0o600)
    with pytest.raises(BadFile, match="is not a signing key: expected an Ed25519 key in PEM, not encrypted"):
        SigningKey(path)


def test_unusable_key_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match=r"file/key\.pem"):
        SigningKey(tmp_path / "file" / "key.pem")


def test_journal_accepts_only_the_first_hosts_key(database: Database) -> None:
    keys = KnownKeys(database)
    keys.check(ONE)
    keys.check(ONE)
    message = f"this host's signing key is {OTHER.hex()}, but the receipts of this journal are signed with {ONE.hex()}"
    with pytest.raises(Conflict, match=message):
        keys.check(OTHER)
    assert [known.key for known in keys.all()] == [ONE]


def test_adopting_a_key_keeps_the_old_ones_known(database: Database) -> None:
    keys = KnownKeys(database)
    keys.check(ONE)
    assert keys.adopt(OTHER)
    assert not keys.adopt(OTHER)
    keys.check(OTHER)
    assert [known.key for known in keys.all()] == [ONE, OTHER]
    assert keys.adopt(ONE)
    assert [known.key for known in keys.all()] == [OTHER, ONE]
    with pytest.raises(Conflict):
        keys.check(OTHER)


def test_only_one_of_several_concurrent_hosts_sets_the_key(database: Database) -> None:
    hosts = [bytes([number]) * 32 for number in range(8)]

    def starts(public: bytes) -> bool:
        try:
            KnownKeys(database).check(public)
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(len(hosts)) as pool:
        started = [host for host, fine in zip(hosts, pool.map(starts, hosts), strict=True) if fine]
    assert started == [known.key for known in KnownKeys(database).all()]
    assert len(started) == 1
