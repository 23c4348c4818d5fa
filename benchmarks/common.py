"""What the benchmarks share: the episodes that they run on, and ground on which nothing is in the way."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from server.episodes.importing import import_release

SAMPLE = Path(__file__).parents[1] / "examples" / "sample" / "sample.json"


class OpenGround:
    """The ground truth never runs into anything."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:  # noqa: ARG002
        """Always."""
        return True


@contextmanager
def data_or_sample(data: Path | None) -> Iterator[Path]:
    """A data folder: the one that was named, or for a while one with the sample episodes."""
    if data is not None:
        yield data
        return
    with tempfile.TemporaryDirectory() as folder:
        import_release([SAMPLE], Path(folder))
        yield Path(folder)
