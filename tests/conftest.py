"""Shared fixtures: a PostgreSQL server, a proxy, an undisturbed run, and servers that start quickly."""

import gc
import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from sqlalchemy import Engine

from arramon_server.runs.storage.database import Database
from arramon_server.sim.raster.camera import compile_kernels
from tests import forked_pools, limits, tiny
from tests.faults.clients import EPISODES, UndisturbedRun, journal_url, undisturbed
from tests.forked import Forked
from tests.order import slow_first
from tests.serving import Server
from tests.shared import shared_folder
from tests.signals import let_programs_be_stopped

pytest_plugins = ["tests.postgres", "tests.proxy"]

settings.register_profile("fixed", derandomize=True)  # the gate judges a change, not a drawing
settings.register_profile("drawn", max_examples=1000)  # for a hunt: pytest --hypothesis-profile=drawn
settings.load_profile("fixed")

gc.disable()  # until everything is imported and collected: half of that time went into looking for garbage

Server.fork = Forked
forked_pools.install()


@pytest.fixture(scope="session")
def undisturbed_run(tmp_path_factory: pytest.TempPathFactory) -> UndisturbedRun:
    """One undisturbed run for all tests that disturb one: by the same agent, on the same episodes."""
    folder = shared_folder(tmp_path_factory, "undisturbed_run", _play_undisturbed)
    return UndisturbedRun(json.loads((folder / "undisturbed_run.json").read_text()), journal_url(folder / "data"))


def _play_undisturbed(folder: Path) -> None:
    tiny.write(folder / "data", count=EPISODES)
    server = Server(folder / "data", "127.0.0.1:0", log=folder / "log")
    results = undisturbed(server, folder / "results")
    assert server.stop() == 0
    (folder / "undisturbed_run.json").write_text(json.dumps(results))


@pytest.fixture
def interruptible() -> Iterator[None]:
    """SIGINT interrupts this process, even where its parent has SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist there is no such hook
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """`--numprocesses auto`: two for each core, as tests wait for servers and clocks; three took longer."""
    return 2 * (os.cpu_count() or 1)


def pytest_configure(config: pytest.Config) -> None:
    """Prepare the processes in which tests run: with xdist its workers, which inherit what it ignores itself."""
    if hasattr(config, "workerinput") or not config.getoption("numprocesses", None):
        let_programs_be_stopped()
        limits.install()


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the camera once, before the processes of xdist and the servers that they start would all do so."""
    if session.config.getoption("numprocesses", None) and not hasattr(session.config, "workerinput"):
        compile_kernels()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with slow tests first, so that at the end no process is left with one of them."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items[:] = slow_first(items, lambda item: item.path, slow, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))


def pytest_collection_finish() -> None:
    """What modules and the collection hold is there to the end: no garbage collection is to look through it."""
    gc.collect()
    gc.freeze()
    gc.enable()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Says in which fonts the pages were looked at: what is right in one may not be in another."""
    reports = [report for kind in ("passed", "failed") for report in terminalreporter.getreports(kind)]
    fonts = {value for report in reports for name, value in report.user_properties if name == "fonts"}
    for font in sorted(map(str, fonts)):
        terminalreporter.line(f"pages shown in: {font}")


@pytest.fixture(autouse=True)
def _databases_are_closed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Close the databases that a test left open: Python 3.13 warns of their connections, in some later test."""
    opened: list[Database] = []
    connect = Database._connect

    def connect_and_remember(database: Database, engine: Engine) -> None:
        connect(database, engine)
        opened.append(database)

    monkeypatch.setattr(Database, "_connect", connect_and_remember)
    yield
    for database in opened:
        database.close()
