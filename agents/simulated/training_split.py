"""Reading of a split for training."""

from pathlib import Path

from arramon_client.errors import UsageError
from arramon_server.episodes.splits import Split, read_named_split
from arramon_server.errors import ArraMonError


def read_training_split(data: Path, name: str) -> Split:
    """Read a split of the data folder.

    Raises:
        UsageError: if there is no such split, or a file of it is invalid.
    """
    try:
        return read_named_split(data, name)
    except ArraMonError as error:
        raise UsageError(str(error)) from error
