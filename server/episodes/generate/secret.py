"""The host's secret, from which a hidden split is drawn: made on first use, readable by its owner alone."""

import contextlib
import os
import secrets
import stat
import tempfile
from pathlib import Path

from server.errors import BadFile, StorageError

NAME = "secret"
"""The file's, in the data folder."""

BYTES = 32


def host_secret(data: Path) -> str:
    """The secret of a data folder, in hexadecimal; made if there is none yet.

    Raises:
        BadFile: if the file can be read by others, or is not a secret.
        StorageError: if it cannot be made or read.
    """
    path = data / NAME
    try:
        if not path.exists():
            data.mkdir(parents=True, exist_ok=True)
            _make(path)
        mode = stat.S_IMODE(path.stat().st_mode)
        text = path.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"cannot make or read the host's secret {path}: {error}") from error
    if mode & 0o077:
        raise BadFile(path, f"has mode {mode:o}, so that others can read it; expected 600 (`chmod 600 {path}`)")
    if len(text) != 2 * BYTES or not set(text) <= set("0123456789abcdef"):
        raise BadFile(path, f"is not a secret: expected {2 * BYTES} hexadecimal digits")
    return text


def _make(path: Path) -> None:
    """Writes a new secret whole, or leaves the one that another process has written meanwhile."""
    file, temporary = tempfile.mkstemp(dir=path.parent, prefix=".secret-")  # of mode 600
    try:
        with os.fdopen(file, "w") as stream:
            stream.write(secrets.token_hex(BYTES) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
        with contextlib.suppress(FileExistsError):
            os.link(temporary, path)
    finally:
        Path(temporary).unlink()
