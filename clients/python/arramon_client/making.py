"""A first set of episodes, made by the server's own program for a participant who has none yet."""

import subprocess
import sys
from pathlib import Path

from arramon_client.embedded import check_installed, end
from arramon_client.errors import EmbeddedServerError

SPLIT, SCALE = "val_unseen", 0.01
"""Which split is made, and how large a part of it: enough to see an agent play, made in seconds."""

STDERR = 2
"""Its descriptor: standard output is for the scores."""

STOP_TIMEOUT = 10.0
"""Seconds that the program may take to stop when it is interrupted."""


def holds_episodes(data: Path) -> bool:
    """Whether there is any split in an embedded server's data folder."""
    return any((data / "splits").glob("*/episodes.jsonl"))


def make_episodes(data: Path, *, module: str = "server", quiet: bool = False) -> None:
    """Makes a small part of a split in a data folder, in every language; what the program says goes to standard error.

    The same episodes come out on every machine. An interrupt leaves nothing behind that would be taken for episodes.

    Args:
        data: the folder; made where it is not there.
        module: the package whose `python -m MODULE generate` makes episodes.
        quiet: show no progress.

    Raises:
        EmbeddedServerError: if the server is not installed, or the program fails; it has then said why.
    """
    check_installed(module)
    # As the embedded server is run (see `embedded`): it must not outlive a client that was killed either.
    program = [sys.executable, "-P", "-m", "arramon_client.lifeline", module]
    command = [*program, "generate", "--split", SPLIT, "--scale", f"{SCALE:g}", "--data", str(data.absolute())]
    with subprocess.Popen(  # noqa: S603 - the interpreter that runs this very program
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL if quiet else STDERR,
        start_new_session=True,
    ) as process:
        try:
            status = process.wait()
        finally:
            if process.poll() is None:  # interrupted
                end(process, STOP_TIMEOUT)
    if status != 0:
        raise EmbeddedServerError(f"a small set of episodes could not be made: `{module} generate` ended with {status}")
