"""Time and size of large standings: `python -m benchmarks.leaderboard.standings --runs 200 --episodes 1205`.

Publishes made-up runs of known truth on a split of made-up episodes, and measures the first look at the standings,
which reads all scores and tests all pairs, a look by another metric, the next look, and one after one more publication.
Then the sizes of the pages, compressed as they are sent: with one language, and with two, where the same agents have
played both and declared costs. `--keep FOLDER` leaves the journal there.
"""

import gzip
import hashlib
import tempfile
import time
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from arramon_server.board.board import Board
from arramon_server.board.cost import Cost
from arramon_server.board.entries import Entries, StoredScores
from arramon_server.board.episode_table import EpisodeTable
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.standings import BOTH
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.epoch_store import EpochStore
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import COMPLETE, Run, RunProgress
from arramon_server.scoring.aggregate import table_rows, with_total
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.web.comparison_page import ComparisonPage
from arramon_server.web.page_texts import all_texts
from arramon_server.web.rendering import Renderer
from arramon_server.web.standings_page import StandingsPage
from arramon_server.web.standings_query import StandingsQuery
from benchmarks.common import data_or_sample, parser_of, positive_int

CLOCKS, STEPS = ClockSettings(60.0, 86_400.0), 150

SERVER = "--server host.example:50551"
"""Options of the client in the commands of a list without runs."""


def main() -> None:
    """Publish the runs, and print the measurements."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=positive_int, default=200, help="runs on the board (default: %(default)s)")
    parser.add_argument(
        "--episodes", type=positive_int, default=1205, help="episodes of the split (default: %(default)s)"
    )
    parser.add_argument("--keep", type=Path, help="empty folder for the journal, which then stays")
    arguments = parser.parse_args()
    with (
        data_or_sample(None) as data,
        nullcontext(str(arguments.keep)) if arguments.keep else tempfile.TemporaryDirectory() as folder,
    ):
        split = _enlarged(next(iter(read_splits(data).values())), arguments.episodes)
        with closing(Database(f"sqlite:///{Path(folder) / 'journal.db'}")) as database:
            _measure(database, split, arguments.runs)


def _enlarged(split: Split, number: int) -> Split:
    """Return a hidden split with so many copies of a split's episodes."""
    found = list(split.episodes.values())
    names = [f"{n:05d}" for n in range(number)]
    copies = {name: replace(found[n % len(found)], episode_id=name) for n, name in enumerate(names)}
    return Split("test_unseen", True, "made up", copies, split.sections, "0" * 64)


def _measure(database: Database, split: Split, number: int) -> None:
    entries, draw = Entries(database), np.random.default_rng(0)
    hard = draw.normal(0.0, 1.0, len(split.episodes))
    for place in range(number):
        _publish(database, entries, split, place, 0.1 + 0.4 * place / max(number - 1, 1), hard)
    board = Board(entries, {split.name: split}, steps_per_phase=STEPS, clocks=CLOCKS)

    _timed("first look", lambda: board.listing(split.name, "en"))
    _timed("first look by nDTW", lambda: board.listing(split.name, "en", "nDTW"))
    _timed("next look", lambda: board.listing(split.name, "en"))
    _publish(database, entries, split, number, 0.3, hard)
    _timed("after one more publication", lambda: board.listing(split.name, "en"))
    lines = board.standings(split.name, "en")
    print(f"{len(lines)} standings, ranks 1 to {lines[-1].rank}")

    splits = {split.name: split}
    epochs = EpochBoard(board, entries, EpochStore(database), Journal(database), splits)
    pages, comparisons, renderer = StandingsPage(board, splits, epochs), ComparisonPage(board), Renderer()
    for code, texts in all_texts().items():
        choice = StandingsQuery(split.name, "en")
        page = renderer.page("standings.html", texts, "/", pages.context(texts, choice, pages.defaults(code), SERVER))
        against = comparisons.context(texts, lines[0].entries[0].run.run_id, {})
        _sized(f"{code} standings", page)
        _sized(f"{code} against", renderer.page("against.html", texts, "/", against))
    for place in range(number):
        _publish(database, entries, split, place, 0.1 + 0.3 * place / max(number - 1, 1), hard, "hi")
    _timed("first look, two languages", lambda: board.listing(split.name, BOTH))
    for code, texts in all_texts().items():
        choice = StandingsQuery(split.name, BOTH)
        page = renderer.page("standings.html", texts, "/", pages.context(texts, choice, pages.defaults(code), SERVER))
        _sized(f"{code} standings, two languages", page)


def _publish(
    database: Database,
    entries: Entries,
    split: Split,
    place: int,
    skill: float,
    hard: "np.typing.NDArray[np.float64]",
    language: str = "en",
) -> None:
    """Publish a run whose agent solves an episode with a chance that depends on its skill and the episode."""
    number = place if language == "en" else place + 1_000_000
    draw = np.random.default_rng(number)
    chance = 1.0 / (1.0 + np.exp(hard - np.log(skill / (1.0 - skill))))
    turns = (draw.random((len(hard), 2, len(METRICS))) < chance[:, None, None]).astype(np.float64)
    turns[:, :, METRICS.index("nDTW")] = draw.beta(4 * chance + 0.1, 4.1 - 4 * chance, size=(2, len(hard))).T
    now = datetime.now(UTC) + timedelta(seconds=place)
    run = Run(
        run_id=f"{number:032x}", participant=f"lab {place % 17}", agent=f"agent-{place}", split=split.name,
        language=language, sensors=("rgb", "depth"), steps_per_phase=STEPS, data_hash=split.data_hash,
        server_version="0.1.0", state=COMPLETE, created_at=now, ended_at=now, step_seconds=CLOCKS.step_seconds,
        bank_seconds=CLOCKS.bank_seconds,
    )  # fmt: skip
    ids = tuple(sorted(split.episodes))
    Journal(database).create(run, ids[:1])
    sections = np.unique([split.episodes[name].section for name in ids], return_inverse=True)[1]
    progress = RunProgress(
        len(ids),
        len(ids),
        90 * len(ids),
        {"AGENT_FINISHED": len(ids)},
        ("jpeg90-224",),
        0,
        False,
        9.0 * (place + 1),
        90,
    )
    scores = StoredScores(progress, table_rows(with_total(turns), sections), f"split:{split.name}|run:{place}")
    play = hashlib.sha256(run.run_id.encode()).hexdigest()
    cost = Cost(1_000_000 * (place + 1), 7_654_321 * (place + 1), 1.25 * place) if language != "en" else None
    entries.publish(run.run_id, "", scores, EpisodeTable(ids, turns, play), by_host=True, cost=cost)


def _sized(name: str, page: bytes) -> None:
    print(f"{name:28} {len(gzip.compress(page)) / 1000:7.1f} kB compressed")


def _timed(name: str, work: Callable[[], object]) -> None:
    start, used = time.perf_counter(), time.process_time()
    work()
    print(f"{name:28} {time.perf_counter() - start:7.3f} s, of which on processors {time.process_time() - used:7.3f} s")


if __name__ == "__main__":
    main()
