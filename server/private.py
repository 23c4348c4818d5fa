"""Files for their owner alone, such as a secret or a key: made whole on first use, refused if others can read them."""

import contextlib
import os
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path

from server.errors import BadFile, StorageError


def private_file(path: Path, make: Callable[[], bytes]) -> bytes:
    """What the file holds; if there is none yet, it is made, of mode 600. Of several makers at once, one wins.

    Args:
        path: the file; its folder is made too.
        make: gives the content of a new file.

    Raises:
        BadFile: if the file can be read by others.
        StorageError: if it cannot be made or read.
    """
    try:
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, make())
        mode = stat.S_IMODE(path.stat().st_mode)
        content = path.read_bytes()
    except OSError as error:
        raise StorageError(f"cannot make or read {path}: {error}") from error
    if mode & 0o077:
        raise BadFile(path, f"has mode {mode:o}, so that others can read it; expected 600 (`chmod 600 {path}`)")
    return content


def _write(path: Path, content: bytes) -> None:
    """Writes a new file whole, or leaves the one that another process has written meanwhile."""
    file, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")  # of mode 600
    try:
        with os.fdopen(file, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        with contextlib.suppress(FileExistsError):
            os.link(temporary, path)
    finally:
        Path(temporary).unlink()
