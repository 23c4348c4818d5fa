"""Files that are written whole or not at all."""

import os
from pathlib import Path

from arramon_client.errors import OutputError


def write_whole(path: Path, text: str) -> None:
    """Writes a text in UTF-8; a file that was there before is replaced only by the whole of it.

    Raises:
        OutputError: if it cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error
