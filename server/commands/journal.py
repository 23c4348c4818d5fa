"""Opens the journal for commands, and checks the data folder first."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from arramon_server.configuration.config import Config
from arramon_server.episodes.splits import SECRET_FILE
from arramon_server.errors import BadInput
from arramon_server.runs.storage.database import Database

DATA_FOLDER_NAMES = ("splits", "journal.db", SECRET_FILE, "signing-key.pem")
"""A data folder contains at least one of these names."""


@contextmanager
def open_journal(
    config: Config, *, patient: bool = False, read_only: bool = False, new: bool = False
) -> Iterator[Database]:
    """Open the journal of the settings.

    Args:
        config: the settings.
        patient, read_only: as for `Database`.
        new: whether an empty folder is accepted too, and becomes a data folder.

    Raises:
        BadInput: if the data folder does not exist, or is not a data folder.
        StorageError: if the journal cannot be opened.
    """
    if not config.journal:
        check_data_folder(config, new=new)
    with closing(Database(config.journal_url, patient=patient, read_only=read_only)) as database:
        yield database


def check_data_folder(config: Config, *, new: bool = False) -> None:
    """Check that the data folder exists and is a data folder: a server would never read files in another folder.

    Args:
        config: the settings.
        new: whether an empty folder is accepted too.

    Raises:
        BadInput: if the folder does not exist, or is not a data folder.
    """
    data = config.data
    if not data.is_dir():
        raise BadInput(f"no folder {data}: expected the server's data folder, set with --data; to make one, {_HOW}")
    if not (_is_data_folder(data) or (new and not any(data.iterdir()))):
        raise BadInput(
            f"{data} is not a data folder: it holds neither episodes (`splits`) nor a journal; expected the server's, "
            f"set with --data; to make one, {_HOW}"
        )


def _is_data_folder(data: Path) -> bool:
    return any((data / name).exists() for name in DATA_FOLDER_NAMES)


_HOW = "run `arramon-server generate` or `arramon-server import-release`"
