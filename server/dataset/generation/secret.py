"""The host's secret that seeds hidden splits: created on first use, readable by its owner alone."""

import secrets
from pathlib import Path

from server.episodes.splits import SECRET
from server.errors import BadFile
from server.private_files import private_file

NAME = SECRET
"""Name of the file in the data folder."""

BYTES = 32


def host_secret(data: Path) -> str:
    """Return the secret of a data folder in hexadecimal, creating it if there is none.

    Raises:
        BadFile: if others can read the file, or its content is not a secret.
        StorageError: if the file cannot be created or read.
    """
    path = data / NAME
    content = private_file(path, lambda: f"{secrets.token_hex(BYTES)}\n".encode())
    text = content.decode(errors="replace").strip()
    if len(text) != 2 * BYTES or not set(text) <= set("0123456789abcdef"):
        raise BadFile(path, f"is not a secret: expected {2 * BYTES} hexadecimal digits")
    return text
