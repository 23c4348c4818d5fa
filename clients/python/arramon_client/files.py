"""Atomic writing of text files."""

import os
from pathlib import Path

from arramon_client.errors import OutputError


def write_whole(path: Path, *texts: str) -> None:
    """Write the concatenated texts to a file in UTF-8, atomically: an existing file is replaced by the complete one.

    Raises:
        OutputError: if it cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w", encoding="utf-8") as file:
            file.writelines(texts)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error
