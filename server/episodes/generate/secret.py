"""The host's secret, from which a hidden split is drawn: made on first use, readable by its owner alone."""

import secrets
from pathlib import Path

from server.errors import BadFile
from server.private import private_file

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
    content = private_file(path, lambda: f"{secrets.token_hex(BYTES)}\n".encode())
    text = content.decode(errors="replace").strip()
    if len(text) != 2 * BYTES or not set(text) <= set("0123456789abcdef"):
        raise BadFile(path, f"is not a secret: expected {2 * BYTES} hexadecimal digits")
    return text
