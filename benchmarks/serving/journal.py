"""Duration of a journal commit of 1, 16 or 128 steps, as in a round of the engine, in milliseconds.

    python -m benchmarks.serving.journal [--postgres URL] [--folder DIR] [--commits 100]

SQLite in the folder, and PostgreSQL by the URL of an empty database, each with and without waiting for the disk. They
alternate, round by round; the table shows the median of the rounds' means, and the duration of one read.
"""

import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from uuid import uuid4

from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, CommitBatch, Run
from benchmarks.common import add_rounds, parser_of, positive_int, text_table

SIZES = (1, 16, 128)


class JournalBench:
    """Commits and reads of one run in one database; the run has as many episodes as a commit has steps."""

    def __init__(self, journal: Journal, size: int) -> None:
        self._journal, self._run_id, self._step = journal, uuid4().hex, 0
        at = datetime.now(UTC)
        run = Run(self._run_id, "b", "b", "b", "en", ("rgb",), 150, "f" * 64, "0", RUNNING, at)
        journal.create(run, [str(number) for number in range(size)])
        self._claims = journal.claim(self._run_id, journal.pending(self._run_id), "p", "w")

    def commit(self, commits: int) -> float:
        """Return the mean duration of a commit, in milliseconds."""
        started = time.perf_counter()
        for _ in range(commits):
            batch = CommitBatch()
            for claim in self._claims:
                batch.add_step(self._run_id, claim.episode_id, claim.fence, self._step, self._step % 4)
            self._journal.commit(batch)
            self._step += 1
        return 1e3 * (time.perf_counter() - started) / commits

    def read(self, reads: int) -> float:
        """Return the mean duration of a small query, in milliseconds."""
        started = time.perf_counter()
        for _ in range(reads):
            self._journal.count_ended(self._run_id)
        return 1e3 * (time.perf_counter() - started) / reads


@contextmanager
def databases(folder: Path, postgres: str) -> Iterator[dict[str, Journal]]:
    """Open the journals to compare, by name."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        urls = {"SQLite": f"sqlite:///{own}/journal.db", **({"PostgreSQL": postgres} if postgres else {})}
        opened = {
            f"{name}{'' if fsync else ', no fsync'}": Database(url, fsync=fsync)
            for name, url in urls.items()
            for fsync in (True, False)
        }
        with ExitStack() as stack:
            yield {name: Journal(stack.enter_context(closing(database))) for name, database in opened.items()}


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("--postgres", default="", help="URL of an empty database")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()), help="folder for SQLite's file")
    parser.add_argument(
        "--commits", type=positive_int, default=100, help="number of commits in each round (default: %(default)s)"
    )
    add_rounds(parser, 5)
    options = parser.parse_args()
    with databases(options.folder, options.postgres) as journals:
        benches = {(name, size): JournalBench(journal, size) for name, journal in journals.items() for size in SIZES}
        taken: dict[tuple[str, int], list[float]] = {key: [] for key in benches}
        read: dict[str, list[float]] = {name: [] for name in journals}
        for _ in range(options.rounds):
            for key, bench in benches.items():
                taken[key].append(bench.commit(options.commits))
            for name in journals:
                read[name].append(benches[name, 1].read(options.commits))
    rows = [
        [name, *(f"{statistics.median(each):.2f}" for each in (*(taken[name, size] for size in SIZES), read[name]))]
        for name in journals
    ]
    print(text_table(["ms", *(f"{size} steps" for size in SIZES), "a read"], rows))


if __name__ == "__main__":
    main()
