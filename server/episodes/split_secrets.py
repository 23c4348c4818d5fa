"""Secrets that seed hidden splits and epochs: created on first use, readable by their owner only."""

import secrets
from pathlib import Path

from arramon_server.episodes.epoch_statement import SECRET_DIGITS, SECRETS_FOLDER
from arramon_server.episodes.splits import SECRET_FILE
from arramon_server.errors import BadFile
from arramon_server.private_files import private_file

NAME = SECRET_FILE
"""Name of the file in the data folder."""

BYTES = SECRET_DIGITS // 2


def host_secret(data: Path) -> str:
    """Return the secret of a data folder in hexadecimal, creating it if there is none.

    Raises:
        BadFile: if others can read the file, or its content is not a secret.
        StorageError: if the file cannot be created or read.
    """
    return _secret_in(data / NAME)


def epoch_secret(data: Path, split: str) -> str:
    """Return the secret of an epoch in hexadecimal, creating it if there is none.

    Args:
        data: the host's data folder.
        split: name of the epoch's split.

    Raises:
        BadFile, StorageError: as for `host_secret`.
    """
    return _secret_in(secret_path(data, split))


def secret_path(data: Path, split: str) -> Path:
    """Return the path of the file with an epoch's secret."""
    return data / SECRETS_FOLDER / f"{split}.secret"


def _secret_in(path: Path) -> str:
    content = private_file(path, lambda: f"{secrets.token_hex(BYTES)}\n".encode())
    text = content.decode(errors="replace").strip()
    if len(text) != 2 * BYTES or not set(text) <= set("0123456789abcdef"):
        raise BadFile(path, f"is not a secret: expected {2 * BYTES} hexadecimal digits")
    return text
