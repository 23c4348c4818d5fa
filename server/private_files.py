"""Private files such as secrets and keys: created on first use, rejected if other users can read them."""

import contextlib
import os
import shlex
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path

from arramon_server.errors import BadFile, StorageError


def private_file(path: Path, make: Callable[[], bytes]) -> bytes:
    """Return the content of a private file; create it with mode 600 if it does not exist.

    If several processes create it at the same time, one of them succeeds, and all return its content.

    Args:
        path: path of the file; its folder is created too.
        make: returns the content of a new file.

    Raises:
        BadFile: if others can read the file.
        StorageError: if the file cannot be created or read.
    """
    try:
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, make())
        content = path.read_bytes()
    except OSError as error:
        raise StorageError(f"cannot create or read {path}: {error}") from error
    check_private_file(path)
    return content


def check_private_file(path: Path) -> None:
    """Check that a file is accessible to its owner only, if it exists.

    Raises:
        BadFile: if others have access; the message names the command that corrects this.
    """
    _check_mode(path, path.is_file(), 0o600)


def check_private_folder(path: Path) -> None:
    """Check that a folder is accessible to its owner only, if it exists, which protects everything in it.

    Raises:
        BadFile: if others have access; the message names the command that corrects this.
    """
    _check_mode(path, path.is_dir(), 0o700)


def _check_mode(path: Path, is_there: bool, expected: int) -> None:
    mode = stat.S_IMODE(path.stat().st_mode) if is_there else expected
    if mode & 0o077:
        problem = f"has mode {mode:o}, so that others can read it; expected {expected:o}"
        raise BadFile(path, f"{problem} (`chmod {expected:o} {shlex.quote(str(path))}`)")


def _write(path: Path, content: bytes) -> None:
    """Write a new file atomically; if another process has created it meanwhile, keep that file."""
    file, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")  # has mode 600
    try:
        with os.fdopen(file, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        with contextlib.suppress(FileExistsError):
            os.link(temporary, path)
    finally:
        Path(temporary).unlink()
