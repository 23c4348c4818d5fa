"""The service clock, with either kind of database; jumps with SQLite, as PostgreSQL's clock is not a test's to move."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.service_clock import LONGEST_TICK, service_time

DAY = 86_400.0


class Wall:
    """A wall clock that the test moves, and the service clocks of two processes that look at it."""

    def __init__(self, folder: Path) -> None:
        self.now = 2e9
        self.skew = 0.0
        url = f"sqlite:///{folder / 'journal.db'}"
        self.databases = [
            Database(url, clock=lambda: self.now),
            Database(url, clock=lambda: self.now + self.skew),
        ]
        self.beat()

    def beat(self, number: int = 0) -> None:
        Journal(self.databases[number]).beat(f"worker {number}")

    def time(self) -> float:
        return seconds(self.databases[0])


def seconds(database: Database) -> float:
    return float(database.read(sa.select(service_time(database.now)))[0][0])


@pytest.fixture
def wall(tmp_path: Path) -> Iterator[Wall]:
    wall = Wall(tmp_path)
    with closing(wall.databases[0]), closing(wall.databases[1]):
        yield wall


def test_it_passes_with_heartbeats_and_between_them(wall: Wall) -> None:
    began = wall.time()
    for count in range(1, 9):
        wall.now += 0.5
        assert wall.time() - began == pytest.approx(0.5 * count)
        if count % 3 == 0:
            wall.beat(count % 2)


@pytest.mark.parametrize(
    ("jump", "passed"), [(7 * DAY, LONGEST_TICK), (-7 * DAY, 0.0), (1e-3, 1e-3), (LONGEST_TICK, LONGEST_TICK)]
)
def test_a_downtime_or_a_jump_moves_it_by_a_tick_at_most(wall: Wall, jump: float, passed: float) -> None:
    began = wall.time()
    wall.now += jump
    assert wall.time() - began == pytest.approx(passed, abs=1e-5)
    wall.beat()
    assert wall.time() - began == pytest.approx(passed, abs=1e-5)
    wall.now += 1.0
    wall.beat()
    assert wall.time() - began == pytest.approx(passed + 1.0, abs=1e-5)


@pytest.mark.parametrize("skew", [-400 * DAY, 400 * DAY])
def test_processes_that_do_not_agree_on_the_time_add_a_tick_a_beat_at_most(wall: Wall, skew: float) -> None:
    wall.skew = skew
    began, beats = wall.time(), 100
    for _ in range(beats):
        wall.now += 1.0
        wall.beat(0)
        wall.beat(1)
    assert 0.0 <= wall.time() - began <= (beats + 1) * LONGEST_TICK


def test_it_never_goes_back(database_url: str) -> None:
    with closing(Database(database_url)) as database:
        journal, times = Journal(database), []
        for _ in range(20):
            times.append(seconds(database))
            journal.beat("w")
        assert times == sorted(times)
