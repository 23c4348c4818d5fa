"""The split for whose episodes a collection's texts are."""

from pathlib import Path

from arramon_server.episodes.splits import Split, read_split, split_folder, split_folders
from arramon_server.errors import NotFound, quoted


def read_base_split(data: Path, name: str) -> Split:
    """Read one split of a data folder.

    Raises:
        NotFound: if there is none of that name; the message lists the existing ones.
        BadFile: if a file is invalid.
    """
    names = [folder.name for folder in split_folders(data)]
    if name not in names:
        raise NotFound(f"there is no split {quoted(name)} in {data}; there are {', '.join(names) or 'none'}")
    return read_split(split_folder(data, name))
