"""Export formats of demonstrations, one module each, imported with its libraries only when the format is used."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, cast

from arramon_dataset.demonstrations.folder import ExportFolder
from arramon_dataset.demonstrations.parts import ExportPart
from arramon_dataset.demonstrations.request import HUGGINGFACE, LEROBOT, MINARI, PLAIN, ResolvedExport
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput

LIBRARIES = {
    PLAIN: (),
    MINARI: ("gymnasium", "minari", "pyarrow"),
    LEROBOT: ("gymnasium", "datasets", "pyarrow"),
    HUGGINGFACE: ("gymnasium", "datasets", "pyarrow"),
}
"""Import names of the libraries that each format needs."""

INSTALL = "pip install 'arramon-server[demos]'"
"""Command that installs all of them."""


class DemonstrationFormat(Protocol):
    """The functions of a format's module."""

    def write_part(self, export: ResolvedExport, split: Split, part: ExportPart, made: Path) -> Mapping[str, Any]:
        """Write the files of a part, and return its summary for `finish`, as plain data.

        Args:
            export: the export.
            split: of the episodes.
            part: the episodes to write.
            made: an empty folder for the files, laid out as in the export's folder.
        """

    def finish(
        self, export: ResolvedExport, split: Split, folder: ExportFolder, parts: Sequence[Mapping[str, Any]]
    ) -> None:
        """Write the files that describe the whole export, once all parts are finished.

        Args:
            export: the export.
            split: of the episodes.
            folder: of the export.
            parts: summaries that `write_part` returned, in order.
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
