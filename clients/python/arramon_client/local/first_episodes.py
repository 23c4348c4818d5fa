"""Generation of a small first set of episodes for a participant who has none."""

import subprocess
import sys
from pathlib import Path

from arramon_client.errors import EmbeddedServerError
from arramon_client.local.embedded import check_installed, terminate

SPLIT, SCALE = "val_unseen", 0.01
"""Split to generate, and the fraction of its episodes: enough to watch an agent play, and generated in seconds."""

STDERR = 2
"""File descriptor of standard error; standard output is for the scores."""

STOP_TIMEOUT = 10.0
"""Time limit for stopping an interrupted generator, in seconds."""


def holds_episodes(data: Path) -> bool:
    """Return whether a data folder contains a split."""
    return any((data / "splits").glob("*/episodes.jsonl"))


def make_episodes(data: Path, *, module: str = "arramon_server", quiet: bool = False) -> None:
    """Generate a small part of a split in every language, with progress and errors on standard error.

    The episodes are the same on every machine. An interrupt leaves no incomplete split behind.

    Args:
        data: the data folder; created if it does not exist.
        module: the package whose `python -m MODULE generate` generates episodes.
        quiet: show no progress.

    Raises:
        EmbeddedServerError: if the server is not installed, or the generator fails after printing the reason.
    """
    check_installed(module)
    # Started like the embedded server (see `embedded`), so that it does not outlive a client that is killed.
    program = [sys.executable, "-P", "-m", "arramon_client.local.lifeline", module]
    command = [*program, "generate", "--split", SPLIT, "--scale", f"{SCALE:g}", "--data", str(data.absolute())]
    with subprocess.Popen(  # noqa: S603 - this interpreter
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL if quiet else STDERR,
        start_new_session=True,
    ) as process:
        try:
            status = process.wait()
        finally:
            if process.poll() is None:  # interrupted
                terminate(process, STOP_TIMEOUT)
    if status != 0:
        raise EmbeddedServerError(f"episodes could not be generated: `{module} generate` exited with status {status}")
