"""Backup of a host's journal, secrets, signing key and splits to a new folder that only its owner can read."""

import os
import shutil
import tempfile
from contextlib import closing
from pathlib import Path

from arramon_server.configuration.config import Config
from arramon_server.episodes import split_secrets
from arramon_server.episodes.epoch_statement import SECRETS_FOLDER
from arramon_server.episodes.splits import split_folder, split_folders, split_hash
from arramon_server.errors import BadInput, Conflict, NotFound, StorageError
from arramon_server.private_files import private_file
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage.database import Database
from arramon_server.runs.transfer.export import export

JOURNAL, EXPORT, KEY = "journal.db", "journal.jsonl.zst", "signing-key.pem"
"""File names in a backup: the journal (from SQLite), its export (from PostgreSQL), and the signing key."""


def back_up(config: Config, folder: Path) -> list[str]:
    """Write a backup, completely or not at all; servers may be running.

    With SQLite the backup can be served directly as a data folder. With PostgreSQL its journal must be imported first.

    Args:
        config: settings of the host; `data`, `journal` and `signing_key` are used.
        folder: path of a new folder, in an existing one.

    Returns:
        Names of the files and splits in the backup.

    Raises:
        BadInput: if the folder exists already, or the secret or the key is malformed or can be read by others.
        NotFound: if there is no data folder, or no key although receipts were signed with one.
        Conflict: if the key is not the journal's, or a split changed while it was copied.
        StorageError: if a file cannot be read or written.
    """
    if folder.exists():
        raise BadInput(f"{folder} exists already, expected the path of a new folder")
    if not config.data.is_dir():
        raise NotFound(f"there is no data folder {config.data}; set it with --data")
    try:
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as temporary:
            new = Path(temporary) / folder.name
            new.mkdir(mode=0o700)
            # The journal is copied first, so that the files that its runs need exist and are copied afterwards.
            with closing(Database(config.journal_url, read_only=True)) as database:
                _copy_journal(database, new)
                _copy_key(database, config.signing_key_path, new)
            _copy_secret(config.data, new)
            _copy_epoch_secrets(config.data, new)
            for split in split_folders(config.data):
                _copy_split(split, new)
            _flush(new)
            new.rename(folder)
        _flush_one(folder.parent)
    except OSError as error:
        raise StorageError(f"cannot write {folder}: {error}") from error
    return sorted(path.relative_to(folder).as_posix() for path in [*folder.iterdir(), *split_folders(folder)])


def _copy_journal(database: Database, new: Path) -> None:
    if database.is_file:
        database.copy(new / JOURNAL)
    else:
        export(database, new / EXPORT)


def _copy_key(database: Database, path: Path, new: Path) -> None:
    known = KnownKeys(database).all()
    if not path.exists():
        if known:
            raise NotFound(
                f"there is no signing key {path}, although receipts were signed with {known[-1].key.hex()}; "
                "set the path of its file with --signing-key"
            )
        return
    key = SigningKey(path).public
    if known and known[-1].key != key:
        raise Conflict(f"{path} has the key {key.hex()}, but this journal's signing key is {known[-1].key.hex()}")
    _copy_private(path, new / KEY)


def _copy_secret(data: Path, new: Path) -> None:
    if (data / split_secrets.NAME).exists():
        split_secrets.host_secret(data)
        _copy_private(data / split_secrets.NAME, new / split_secrets.NAME)


def _copy_epoch_secrets(data: Path, new: Path) -> None:
    for path in sorted((data / SECRETS_FOLDER).glob("*.secret")):
        split_secrets.epoch_secret(data, path.stem)
        _copy_private(path, new / SECRETS_FOLDER / path.name)


def _copy_private(path: Path, copy: Path) -> None:
    content = path.read_bytes()
    private_file(copy, lambda: content)


def _copy_split(split: Path, new: Path) -> None:
    copy = split_folder(new, split.name)
    changed = f"{split} changed while it was copied; repeat the backup"
    try:
        shutil.copytree(split, copy)
    except shutil.Error as error:
        raise Conflict(changed) from error
    if split_hash(copy) != split_hash(split):
        raise Conflict(changed)


def _flush(folder: Path) -> None:
    """Flush a folder and everything in it to the disk."""
    for path in (*folder.rglob("*"), folder):
        _flush_one(path)


def _flush_one(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
