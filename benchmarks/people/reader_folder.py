"""A machine reader's folder: its files, and the keys that are sent to the background process that serves it."""

import contextlib
import json
import socket
import time
from pathlib import Path
from typing import Any

LETTERS = "FLRP"
"""Keys, in the order of the actions' numbers: forward, left, right, pick up or place."""

MAX_KEYS = 8
"""Number of keys in one press, whose frames fit on one sheet."""

SOCKET, RUN, OVER = "keys.sock", "run.json", "over.txt"
"""Files in a folder: where keys are taken, what is played, and why nothing more is."""

PREFIX = "machine reader "
"""Beginning of the participant's name of every machine reader, which tells its runs from those of people."""

START_SECONDS = 60.0
"""Time for which a press waits for a background process that has just been started."""


class ReaderError(Exception):
    """A command of a machine reader is not possible; the message says why."""


def ask(folder: Path, letters: str) -> str:
    """Press keys at the background process of a folder, and return what the page shows then.

    Args:
        folder: the reader's folder.
        letters: letters of the keys; empty to press none.

    Raises:
        ReaderError: if no background process answers.
    """
    until = time.monotonic() + START_SECONDS
    while True:
        if (over := folder / OVER).exists():
            return over.read_text(encoding="utf-8")
        try:
            with contextlib.chdir(folder), socket.socket(socket.AF_UNIX) as connection:
                connection.connect(SOCKET)
                connection.sendall(f"{letters}\n".encode())
                with connection.makefile(encoding="utf-8") as answer:
                    text = answer.read()
            if text:
                return text
            raise ReaderError(f"the process of {folder} ended during the answer; start it again with `serve`")
        except (FileNotFoundError, ConnectionRefusedError):
            if time.monotonic() > until:
                raise ReaderError(f"no process serves {folder}; start one with `serve --folder {folder}`") from None
            time.sleep(0.2)


def is_served(folder: Path) -> bool:
    """Return whether a process takes keys in a folder."""
    try:
        with contextlib.chdir(folder), socket.socket(socket.AF_UNIX) as connection:
            connection.connect(SOCKET)
    except (FileNotFoundError, ConnectionRefusedError):
        return False
    return True


def read_run(folder: Path) -> dict[str, Any]:
    """Return what a folder plays.

    Raises:
        ReaderError: if it is no reader's folder.
    """
    try:
        content: dict[str, Any] = json.loads((folder / RUN).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ReaderError(f"{folder} is no reader's folder: it has no {RUN}") from None
    return content


def write_run(folder: Path, settings: dict[str, Any]) -> None:
    """Write what a folder plays."""
    (folder / RUN).write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
