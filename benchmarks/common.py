"""Shared by the benchmarks: their data folder, and ground without obstacles."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from arramon_dataset.release.importer import import_release

SAMPLE = Path(__file__).parents[1] / "examples" / "sample" / "sample.json"


class OpenGround:
    """Ground without obstacles; ground-truth paths never collide with anything."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:  # noqa: ARG002
        """Return True."""
        return True


@contextmanager
def data_or_sample(data: Path | None) -> Iterator[Path]:
    """Provide the given data folder, or a temporary one with the sample episodes."""
    if data is not None:
        yield data
        return
    with tempfile.TemporaryDirectory() as folder:
        import_release([SAMPLE], Path(folder))
        yield Path(folder)
