"""A real PostgreSQL for tests: a cluster in a temporary folder, on a loopback port."""

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psycopg
import pytest

from arramon_server.runs.storage.database import Database
from tests.ports import free_port
from tests.programs import program, start, stop

SETTINGS = {
    "listen_addresses": "127.0.0.1",
    "unix_socket_directories": "",
    "shared_buffers": "32MB",
    # What these tests break are processes, not the machine.
    "fsync": "off",
    "full_page_writes": "off",
    "max_wal_size": "128MB",
    "autovacuum": "off",  # it would look at the databases of all tests again and again
}

TEMPLATE = "journal_template"
"""Name of the database that new ones are copied from."""


class Cluster:
    """One PostgreSQL server. It can be stopped, killed and started again on the same port."""

    def __init__(self, binaries: Path, folder: Path) -> None:
        self._binaries, self._data, self._log = binaries, folder / "data", folder / "log"
        self._password = uuid.uuid4().hex
        # PostgreSQL does not run as root.
        self._user = next(n for n in ("postgres", "nobody") if _exists(n)) if os.geteuid() == 0 else None
        password = folder / "password"
        password.write_text(self._password)
        if self._user:
            for path in (folder, password):
                shutil.chown(path, self._user)
        command = [f"{binaries}/initdb", f"--pgdata={self._data}", "--username=arramon", f"--pwfile={password}"]
        command += ["--auth=scram-sha-256", "--encoding=UTF8", "--no-locale", "--no-sync"]
        subprocess.run(command, check=True, user=self._user, capture_output=True, cwd=folder)
        self.port = free_port()
        self._has_template = False
        self.start()

    def url(self, database: str) -> str:
        return f"postgresql://arramon:{self._password}@127.0.0.1:{self.port}/{database}"

    def drop(self, url: str) -> None:
        """Remove a database, before all of it is written to the disk; connections that a test left open are closed."""
        self.run(f"DROP DATABASE {url.rpartition('/')[2]} WITH (FORCE)")

    def create(self) -> str:
        """The URL of a new database with the tables of a journal, and nothing in them: a copy of one made once."""
        if not self._has_template:
            self.run(f"CREATE DATABASE {TEMPLATE}")
            Database(self.url(TEMPLATE)).close()
            self._has_template = True
        url = self._create(f"TEMPLATE {TEMPLATE}")
        with psycopg.connect(url, autocommit=True) as connection:  # a new journal's clock starts at the present
            connection.execute("UPDATE service_clock SET seconds = extract(epoch FROM clock_timestamp())")
            connection.execute("UPDATE service_clock SET seen = seconds")
        return url

    def create_empty(self) -> str:
        """The URL of a new database without tables."""
        return self._create()

    def _create(self, options: str = "") -> str:
        name = f"test_{uuid.uuid4().hex[:12]}"
        self.run(f"CREATE DATABASE {name} {options}")
        return self.url(name)

    def run(self, statement: str, **values: object) -> list[tuple[Any, ...]]:
        """A statement as the administrator; the rows that it gives, if any."""
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            cursor = connection.execute(statement.encode(), values)
            return cursor.fetchall() if cursor.description else []

    def start(self) -> None:
        settings = [part for name, value in SETTINGS.items() for part in ("-c", f"{name}={value}")]
        command = [str(self._binaries / "postgres"), "-D", str(self._data), "-p", str(self.port), *settings]
        self._process = start(command, self._log, user=self._user)
        while True:
            try:
                self.run("SELECT 1")
            except psycopg.OperationalError:
                assert self._process.poll() is None, self._log.read_text()
                time.sleep(0.05)
            else:
                return

    def signal(self, number: signal.Signals) -> None:
        """To the server's first process: SIGQUIT ends all of them at once, as a crash does."""
        os.kill(self.processes()[0], number)

    def processes(self) -> list[int]:
        """The server's first process, and its children; Linux only."""
        first = int((self._data / "postmaster.pid").read_text().split()[0])
        return [first, *map(int, Path(f"/proc/{first}/task/{first}/children").read_text().split())]

    def crash(self) -> None:
        """Ends it without a goodbye; what was committed is there at the next start."""
        self.signal(signal.SIGQUIT)
        self.stop()

    def stop(self) -> None:
        stop(self._process)


def binaries() -> Path:
    """Where PostgreSQL's programs are; skips where there are none."""
    return program("initdb", "postgresql", "/usr/lib/postgresql/*/bin").parent


@contextmanager
def running_cluster() -> Iterator[Cluster]:
    """A PostgreSQL of one's own, gone at the end with all that it held."""
    programs = binaries()
    folder = Path(tempfile.mkdtemp(prefix="arramon-pg-"))  # pytest's own folders are closed to other users
    try:
        cluster = Cluster(programs, folder)
        try:
            yield cluster
        finally:
            cluster.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def cluster() -> Iterator[Cluster]:
    """The tests' own PostgreSQL, one a session; whoever stops it starts it again."""
    with running_cluster() as cluster:
        yield cluster


@pytest.fixture
def postgres_url(cluster: Cluster) -> Iterator[str]:
    """A new database in it, with an empty journal's tables."""
    url = cluster.create()
    yield url
    cluster.drop(url)


def await_lock(url: str, task: Future[Any]) -> None:
    """Wait until a task is over, or a connection to the database waits for a lock that another one holds."""
    waiting = "SELECT 1 FROM pg_stat_activity WHERE datname = current_database() AND wait_event_type = 'Lock'"
    with psycopg.connect(url, autocommit=True) as connection:
        while not task.done() and connection.execute(waiting).fetchone() is None:
            time.sleep(0.02)


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """A database of each kind for a new journal."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'journal.db'}"
    url: str = request.getfixturevalue("postgres_url")
    return url


def _exists(user: str) -> bool:
    try:
        pwd.getpwnam(user)
    except KeyError:
        return False
    return True
