"""Backups: made while a server plays; a server started on one continues the runs."""

import shutil
import stat
import subprocess
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from arramon_server.backup import EXPORT, JOURNAL, KEY, back_up
from arramon_server.cli import main
from arramon_server.configuration.config import Config
from arramon_server.episodes.split_secrets import host_secret
from arramon_server.episodes.splits import read_splits
from arramon_server.errors import ArraMonError, BadFile, BadInput, Conflict, NotFound, StorageError
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.receipts import Receipts, stored_receipt
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.transfer.export import export
from arramon_server.runs.transfer.restore import import_archive
from tests import tiny
from tests.faults.clients import (
    EPISODES,
    UndisturbedRun,
    check_same,
    client,
    finish,
    journal_url,
    played_on,
    results,
    run_id,
    undisturbed,
)
from tests.played import play
from tests.postgres import Cluster
from tests.serving import Server


@pytest.mark.slow
def test_server_continues_from_a_backup_after_losing_its_data(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data, backup, url = tmp_path / "data", tmp_path / "backup", journal_url(tmp_path / "data")
    tiny.write(data, count=EPISODES)
    secret = host_secret(data)
    server = Server(data)
    once = undisturbed(server, tmp_path / "once")
    key = SigningKey(data / KEY).public
    playing = client(server.address, tmp_path / "again")
    run = run_id(playing)
    recorded = played_on(url, run, 20)
    assert main(["backup", str(backup), "--data", str(data)]) == 0
    assert capsys.readouterr().out == f"{backup}: journal.db, secret, signing-key.pem, splits, splits/tiny\n"
    played_on(url, run, recorded)  # it has not stood still
    playing.kill()
    playing.communicate()
    server.kill()
    shutil.rmtree(data)

    subprocess.run(["cp", "-a", backup, data], check=True)
    with closing(Database(url, read_only=True)) as database:
        assert recorded <= Journal(database).progress(run).steps
        receipt = stored_receipt(database, once["run"]["run_id"])
    server.start()
    assert host_secret(data) == secret
    assert SigningKey(data / KEY).public == key
    finish(client(server.address, tmp_path / "again", "--resume", run))
    check_same(url, UndisturbedRun(once, url), results(tmp_path / "again"))
    assert receipt is not None
    signed = next((tmp_path / "once").glob("*.receipt.json"))
    assert receipt.signature.hex() in signed.read_text()
    assert server.stop() == 0
    assert main(["rescore", "--all", "--data", str(data)]) == 0


def filled(data: Path, database: Database, key: Path | None = None) -> None:
    """A host's data folder, with a hidden split and a run that has a receipt."""
    tiny.write(data, count=3)
    tiny.write(data, "unseen", count=3, hidden=True)
    host_secret(data)
    signing = SigningKey(key or data / KEY)
    KnownKeys(database).check(signing.public)
    splits = read_splits(data)
    play(database, splits["tiny"], "over")
    play(database, splits["unseen"], "half", actions={"0": tiny.ACTIONS, "1": (0, 0, 3), "2": ()}, over=False)
    Receipts(database, splits, signing).of(HOST, "over")


@pytest.fixture
def config(tmp_path: Path) -> Config:
    """The settings of such a host, with SQLite."""
    config = Config(data=tmp_path / "data")
    config.data.mkdir()
    with closing(Database(config.journal_url)) as database:
        filled(config.data, database)
    return config


def test_backup_is_readable_by_its_owner_only(config: Config, tmp_path: Path) -> None:
    assert back_up(config, tmp_path / "backup") == [JOURNAL, "secret", KEY, "splits", "splits/tiny", "splits/unseen"]
    private = ("", JOURNAL, "secret", KEY, "splits/unseen")
    modes = {name: stat.S_IMODE((tmp_path / "backup" / name).stat().st_mode) for name in private}
    assert modes == {"": 0o700, JOURNAL: 0o600, "secret": 0o600, KEY: 0o600, "splits/unseen": 0o700}
    for name in ("secret", KEY, "splits/unseen/episodes.jsonl"):
        assert (tmp_path / "backup" / name).read_bytes() == (config.data / name).read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["backup", "data"]


def test_signing_key_stored_elsewhere_is_restored_from_a_backup(tmp_path: Path) -> None:
    config = Config(data=tmp_path / "data", signing_key=tmp_path / "keys" / "host.pem")
    config.data.mkdir()
    with closing(Database(config.journal_url)) as database:
        filled(config.data, database, config.signing_key)
    back_up(config, tmp_path / "backup")
    restored = Config(data=tmp_path / "backup")
    assert SigningKey(restored.signing_key_path).public == SigningKey(config.signing_key_path).public


def test_backup_includes_an_export_of_a_postgresql_journal(cluster: Cluster, tmp_path: Path) -> None:
    config = Config(data=tmp_path / "data", journal=cluster.create())
    config.data.mkdir()
    backup = tmp_path / "backup"
    with closing(Database(config.journal_url)) as database:
        filled(config.data, database)
        assert back_up(config, backup) == [EXPORT, "secret", KEY, "splits", "splits/tiny", "splits/unseen"]
        export(database, tmp_path / "before")
    with closing(Database(cluster.create(), patient=True)) as restored:
        import_archive(restored, backup / EXPORT)
        export(restored, tmp_path / "after")
    assert (tmp_path / "after").read_bytes() == (tmp_path / "before").read_bytes()


def no_key(data: Path) -> None:
    (data / KEY).unlink()


def another_key(data: Path) -> None:
    (data / KEY).unlink()
    SigningKey(data / KEY)


def open_key(data: Path) -> None:
    (data / KEY).chmod(0o644)


def open_secret(data: Path) -> None:
    (data / "secret").chmod(0o644)


def no_journal(data: Path) -> None:
    (data / JOURNAL).unlink()


def broken_journal(data: Path) -> None:
    content = bytearray((data / JOURNAL).read_bytes())
    content[8192:] = b"x" * (len(content) - 8192)
    (data / JOURNAL).write_bytes(content)


def no_data(data: Path) -> None:
    shutil.rmtree(data)


def backup_there(data: Path) -> None:
    (data.parent / "backup").mkdir()


@pytest.mark.parametrize(
    ("spoil", "error", "says"),
    [
        (no_key, NotFound, "there is no signing key"),
        (another_key, Conflict, "but this journal's signing key is"),
        (open_key, BadFile, "has mode 644"),
        (open_secret, BadFile, "has mode 644"),
        (no_journal, StorageError, "there is no journal"),
        (broken_journal, StorageError, "journal"),
        (no_data, NotFound, "there is no data folder"),
        (backup_there, BadInput, "exists already"),
    ],
)
def test_incomplete_backup_is_refused_and_leaves_no_files(
    config: Config, tmp_path: Path, spoil: Callable[[Path], None], error: type[ArraMonError], says: str
) -> None:
    spoil(config.data)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(error, match=says):
        back_up(config, tmp_path / "backup")
    assert [path for path in sorted(tmp_path.rglob("*")) if not path.name.endswith(("-shm", "-wal"))] == before
