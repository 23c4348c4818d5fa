"""The service under the soak test: server processes on one journal, and the injection of faults."""

import os
import random
import resource
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import sqlalchemy as sa

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import OPEN
from benchmarks.soak.players import SoakPlayer
from tests import tiny
from tests.certificates import Authority
from tests.faults.clients import EPISODES, pause
from tests.postgres import Cluster, running_cluster
from tests.process.test_workers import children
from tests.serving import Server

PATIENCE = 120.0
"""Seconds within which a step must be recorded after any fault."""

FULL_DISK_LIMIT = (4096, resource.RLIM_INFINITY)
"""Limit of the size of a process's files: every write beyond it fails, as on a full disk."""

Steps = dict[tuple[str, str], tuple[int, int]]
"""Claim number (fence) and number of recorded steps of each open episode, by run and episode id."""


class NoProgress(Exception):
    """No step was recorded within `PATIENCE` seconds."""


class SoakService:
    """One host with SQLite, or two with a shared PostgreSQL; each has one or several processes.

    Attributes:
        url: URL of the journal.
        hosts: first process of each host.
        away: killed hosts that are not restarted yet.
        exits: statuses of hosts that exited on their own and were restarted: 1 after their workers died too often in
            a row; negative for a crash.
    """

    def __init__(self, hosts: Sequence[Server], url: str, cluster: Cluster | None, database: Database) -> None:
        self.hosts, self.url, self.cluster = hosts, url, cluster
        self.away: list[Server] = []
        self.exits: list[int] = []
        self._database = database

    @property
    def data(self) -> Path:
        """The first host's data folder."""
        return self.hosts[0].data

    def open_episodes(self) -> Steps:
        """Return the open episodes."""
        episodes, steps = tables.episodes.c, tables.steps.c
        last = (
            sa.select(sa.func.max(steps.step))
            .where(steps.run_id == episodes.run_id, steps.episode_id == episodes.episode_id)
            .scalar_subquery()
            .label("last")
        )
        query = sa.select(episodes.run_id, episodes.episode_id, episodes.epoch, last).where(episodes.state == OPEN)
        return {
            (row.run_id, row.episode_id): (row.epoch, 0 if row.last is None else row.last + 1)
            for row in self._database.read(query)
        }

    def wait_for_steps(self) -> None:
        """Wait until a new step is recorded."""
        before = self.open_episodes()
        for _ in self._looks():
            now = self.open_episodes()
            if any(steps > before.get(episode, (0, 0))[1] for episode, (_, steps) in now.items()):
                return

    def wait_and_revive(self, seconds: float) -> None:
        """Wait for some seconds, and restart hosts that exit meanwhile."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.revive()
            time.sleep(0.1)

    def wait_for_return(self, lost: Steps) -> bool:
        """Wait for a step of an episode that was open when a process died and has been claimed again since.

        Returns:
            Whether there was one: False if the process that died held no episodes.
        """
        for _ in self._looks():
            now = self.open_episodes()
            shared = [(lost[episode], now[episode]) for episode in lost.keys() & now.keys()]
            if any(later > earlier and steps > before for (earlier, before), (later, steps) in shared):
                return True
            if all(later == earlier and steps > before for (earlier, before), (later, steps) in shared):
                return False
        raise AssertionError("unreachable: the polling ends with an exception")

    def revive(self) -> None:
        """Restart hosts that exited because a worker died repeatedly, as a host's supervisor does."""
        for host in self.hosts:
            if host not in self.away and host.process.poll() is not None:
                self.exits.append(host.process.wait(PATIENCE))
                host.start()

    def stop(self) -> None:
        """Stop all hosts; failing exit statuses are added to `exits`."""
        self.exits += filter(None, [_end(host) for host in self.hosts if host not in self.away])

    def _looks(self) -> Iterator[None]:
        """Yield at each poll, for `PATIENCE` seconds."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            yield
            self.revive()
            time.sleep(0.01)
        raise NoProgress(f"no step was recorded within {PATIENCE:.0f} seconds")


@contextmanager
def service(kind: str, workers: int, folder: Path, *, hosted: bool = False) -> Iterator[SoakService]:
    """Start all hosts on the loopback, and stop them at the end.

    Args:
        kind: the database, sqlite or postgresql.
        workers: number of processes of each host.
        folder: folder for the hosts' data.
        hosted: with the settings of a host: TLS, tokens, limits, and a log at `info` (the files `log-N`).
    """
    with ExitStack() as stack:
        cluster = stack.enter_context(running_cluster()) if kind == "postgresql" else None
        url = cluster.create() if cluster else f"sqlite:///{folder / 'journal.db'}"
        shared = ["--journal", url, "--signing-key", str(folder / "key.pem"), "--workers", str(workers)]
        shared += ["--drain-seconds", "5"]
        shared += _settings_of_a_host(folder) if hosted else []
        database, hosts = stack.enter_context(closing(Database(url))), list[Server]()
        there = SoakService(hosts, url, cluster, database)
        stack.callback(there.stop)
        for listen in ("127.0.0.2:0", "127.0.0.3:0") if cluster else ("127.0.0.1:0",):
            data = folder / f"host-{len(hosts)}"
            tiny.write(data, count=EPISODES)
            hosts.append(Server(data, listen, *shared, log=folder / f"log-{len(hosts)}"))
        yield there


AUTHORITY = "authority.pem"
"""File name of the authority's certificate in the service's folder, trusted by players over TLS."""


def _settings_of_a_host(folder: Path) -> list[str]:
    """Return a host's settings: TLS, required tokens, limits, and the log settings of `deploy/kubernetes`."""
    authority = Authority()
    (folder / AUTHORITY).write_bytes(authority.pem)
    (folder / "tls").mkdir()
    certificate, key = authority.sign(folder / "tls")
    settings = ["--tls-certificate", str(certificate), "--tls-key", str(key), "--no-anonymous"]
    settings += ["--runs-per-day", "100000", "--runs-at-once", "2", "--streams-at-once", "16"]
    return [*settings, "--log", "info", "--log-format", "json"]


def _end(host: Server) -> int:
    """Stop a host in any state, also if its processes are paused, and return its exit status."""
    if (status := host.process.poll()) is not None:
        return status
    for process in (host.process.pid, *children(host.process.pid)):
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGCONT)
    return host.stop()


class FaultInjector:
    """Injection of faults, one at a time; each method returns a description.

    Args:
        service: the service.
        players: the players.
        chance: random generator for targets and durations.
        folder: folder for the results of second clients.

    Attributes:
        times: seconds from the kill of a process with open episodes to the next step of one of them, for each kill.
        seconds: second clients, which play the run of another client.
        complaints: descriptions of errors.
    """

    def __init__(
        self, service: SoakService, players: Sequence[SoakPlayer], chance: random.Random, folder: Path
    ) -> None:
        self._service, self._players, self._chance, self._folder = service, players, chance, folder
        self.times: list[float] = []
        self.seconds: list[SoakPlayer] = []
        self.complaints: list[str] = []

    def kill_server(self) -> str:
        """Send SIGKILL to a worker, or to all processes of a host."""
        host = self._host()
        workers = children(host.process.pid)
        one = bool(workers) and self._chance.random() < 0.5
        at = time.monotonic()
        if one:
            os.kill(self._chance.choice(workers), signal.SIGKILL)
            lost = self._service.open_episodes()
        else:
            host.kill()
            for worker in workers:
                os.kill(worker, signal.SIGKILL)
            lost = self._service.open_episodes()
            self._leave(host)
            if len(self._service.hosts) == 1:
                host.start()
            else:  # it is restarted once others have taken over; then a player is redirected to it
                self._service.away.append(host)
        returned = self._service.wait_for_return(lost)
        if returned:
            self.times.append(time.monotonic() - at)
        while self._service.away:
            self._service.away.pop().start()
            self._send(self._chance.choice(self._players), host)
        what = "a worker" if one else f"the host at {host.address}"
        return f"{what}; " + (f"play continued after {self.times[-1]:.2f} s" if returned else "it held no episodes")

    def stop_server(self) -> str:
        """Send SIGTERM, as for an upgrade, and restart."""
        host = self._host()
        self._leave(host)
        if status := host.stop():
            self.complaints.append(f"the host at {host.address} was stopped and ended with status {status}")
        host.start()
        return f"the host at {host.address}"

    def pause_server(self) -> str:
        """Pause a process; another host, if any, takes over its episodes."""
        host, seconds = self._host(), self._chance.uniform(0.5, 8.0)
        process = self._chance.choice(children(host.process.pid) or [host.process.pid])
        pause(process, None if self._service.cluster else Path(self._service.url.removeprefix("sqlite:///")))
        self._leave(host)
        time.sleep(seconds)
        os.kill(process, signal.SIGCONT)
        return f"a process of the host at {host.address}, for {seconds:.1f} s"

    def kill_client(self) -> str:
        """Send SIGKILL to a client; it is restarted with --resume."""
        player = self._player()
        player.signal(signal.SIGKILL)
        self._until_back(player)
        return f"in run {player.run}"

    def pause_client(self) -> str:
        """Pause a client."""
        player, seconds = self._player(), self._chance.uniform(0.5, 4.0)
        player.signal(signal.SIGSTOP)
        time.sleep(seconds)
        player.signal(signal.SIGCONT)
        return f"for {seconds:.1f} s"

    def start_second_client(self) -> str:
        """Start a second client that plays the same run to its end."""
        first = self._player()
        run = first.run
        output = self._folder / f"second-{len(self.seconds)}"
        second = SoakPlayer(self._host().address, output, first.access, first.settings)
        self.seconds.append(second.start(run))
        return f"run {run}"

    def reset(self) -> str:
        """Reset every connection of a player, as a restarted proxy does."""
        player = self._player()
        before = player.relay.resets
        player.relay.reset()
        self._until_back(player)
        return f"{player.relay.resets - before} of them"

    def silence(self) -> str:
        """Delay all traffic of a player for a while, without closing its connections."""
        relay, seconds = self._player().relay, self._chance.uniform(0.5, 4.0)
        relay.freeze()
        time.sleep(seconds)
        relay.thaw()
        return f"for {seconds:.1f} s"

    def fill_disk(self) -> str:
        """Prevent the server's files from growing for a while, as on a full disk."""
        host, seconds = self._host(), self._chance.uniform(0.3, 2.0)
        for limits in (FULL_DISK_LIMIT, (resource.RLIM_INFINITY, resource.RLIM_INFINITY)):
            # A worker that was started meanwhile has its parent's limit; one that has ended needs none.
            for process in (host.process.pid, *children(host.process.pid)):
                with suppress(ProcessLookupError):
                    resource.prlimit(process, resource.RLIMIT_FSIZE, limits)
            if limits is FULL_DISK_LIMIT:
                time.sleep(seconds)
        return f"for {seconds:.1f} s"

    def end_database(self) -> str:
        """Crash or stop PostgreSQL, and restart it."""
        cluster, seconds, crash = self._service.cluster, self._chance.uniform(0.0, 3.0), self._chance.random() < 0.5
        assert cluster is not None
        if crash:
            cluster.crash()
        else:
            cluster.stop()
        time.sleep(seconds)
        cluster.start()
        return f"{'by a crash' if crash else 'by a clean stop'}, for {seconds:.1f} s"

    def _host(self) -> Server:
        """Choose a host to which a player connects."""
        target = self._chance.choice(self._players).relay.target
        return next(host for host in self._service.hosts if host.address == target)

    def _player(self) -> SoakPlayer:
        """Choose a player with a current run; wait until there is one."""
        for _ in range(int(PATIENCE / 0.02)):
            playing = [player for player in self._players if player.is_playing]
            if playing:
                return self._chance.choice(playing)
            time.sleep(0.02)
        raise NoProgress(f"no client started a run within {PATIENCE:.0f} seconds")

    def _until_back(self, player: SoakPlayer) -> None:
        """Wait until a player whose connection broke continues, so that it does not delay the next measurement."""
        mine = {episode: known for episode, known in self._service.open_episodes().items() if episode[0] == player.run}
        self._service.wait_for_return(mine)

    def _leave(self, host: Server) -> None:
        """Redirect a host's clients to another host, if there is one, like a proxy with health checks."""
        others = [each for each in self._service.hosts if each is not host]
        for player in (*self._players, *self.seconds):
            if others and player.relay.target == host.address:
                self._send(player, self._chance.choice(others))

    @staticmethod
    def _send(player: SoakPlayer, host: Server) -> None:
        player.relay.target = host.address
        player.relay.reset()


class FaultKind(NamedTuple):
    """A kind of fault, and the method that injects it."""

    name: str
    make: Callable[[FaultInjector], str]


KILL = FaultKind("server killed", FaultInjector.kill_server)

OTHERS = (
    FaultKind("client killed", FaultInjector.kill_client),
    FaultKind("client paused", FaultInjector.pause_client),
    FaultKind("a second client played the run", FaultInjector.start_second_client),
    FaultKind("connections reset", FaultInjector.reset),
    FaultKind("connections silent", FaultInjector.silence),
    FaultKind("server paused", FaultInjector.pause_server),
    FaultKind("server stopped cleanly", FaultInjector.stop_server),
)
"""Faults for every database."""

OF_DATABASE = {
    "sqlite": FaultKind("disk full", FaultInjector.fill_disk),
    "postgresql": FaultKind("database ended", FaultInjector.end_database),
}
