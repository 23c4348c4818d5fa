"""The formats of demonstrations, one module each. Only that of the format in use is imported, with its libraries."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, cast

from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.request import HUGGINGFACE, LEROBOT, MINARI, PLAIN, Export
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput

LIBRARIES = {
    PLAIN: (),
    MINARI: ("gymnasium", "minari", "pyarrow"),
    LEROBOT: ("gymnasium", "datasets", "pyarrow"),
    HUGGINGFACE: ("gymnasium", "datasets", "pyarrow"),
}
"""By format the libraries that it needs, by the names under which they are imported."""

INSTALL = "pip install 'arramon-server[demos]'"
"""Installs all of them."""


class DemonstrationFormat(Protocol):
    """A format: a module with these functions."""

    def write_part(self, export: Export, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:
        """Write the files of a part, and return what `finish` has to know of it, as plain data.

        Args:
            export: what is exported.
            split: with the episodes.
            part: some of its demonstrations.
            made: an empty folder; files in it are laid out as in the export's folder.
        """

    def finish(self, export: Export, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]) -> None:
        """Write the files that describe the whole, when all parts are there.

        Args:
            export: what was exported.
            split: with the episodes.
            folder: of the export.
            parts: what `write_part` returned, in order.
        """


def load_format(name: str) -> DemonstrationFormat:
    """Return a format by name.

    Raises:
        BadInput: if its libraries are not installed; the message says how to install them.
    """
    missing = [library for library in LIBRARIES[name] if find_spec(library) is None]
    if missing:
        raise BadInput(
            f"the format {name!r} needs {', '.join(missing)}, which this installation lacks; "
            f"expected the libraries of the extra `demos`: {INSTALL}"
        )
    return cast(DemonstrationFormat, import_module(f"{__name__}.{name}"))
