"""What the soak disturbs: server processes on one journal, and every fault that it makes."""

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
from soak_players import Player

from server.runs import tables
from server.runs.database import Database
from server.runs.records import OPEN
from tests import tiny
from tests.faults.clients import EPISODES, pause
from tests.postgres import Cluster, running_cluster
from tests.serving import Server
from tests.test_workers import children

PATIENCE = 120.0
"""Seconds in which a step must be recorded again after any fault."""

FULL = (4096, resource.RLIM_INFINITY)
"""How long the operating system lets a process's files become, at most: every write beyond fails, as on a full disk."""

Steps = dict[tuple[str, str], tuple[int, int]]
"""The open episodes, by run and id: under which claim, and how many steps are recorded."""


class Stuck(Exception):
    """Nothing is recorded any more."""


class Service:
    """One host with SQLite, or two with one PostgreSQL; each has one process or several.

    Attributes:
        url: of the journal.
        hosts: the first process of each.
        away: those that were killed and stay away for now.
        given_up: hosts whose workers died too often in a row, and that were started again as a whole.
    """

    def __init__(self, hosts: Sequence[Server], url: str, cluster: Cluster | None, database: Database) -> None:
        self.hosts, self.url, self.cluster = hosts, url, cluster
        self.away: list[Server] = []
        self.given_up = 0
        self._database = database

    @property
    def data(self) -> Path:
        """The first host's data folder."""
        return self.hosts[0].data

    def open_episodes(self) -> Steps:
        """What is being played."""
        episodes, steps = tables.episodes.c, tables.steps.c
        last = (
            sa.select(sa.func.max(steps.step))
            .where(steps.run_id == episodes.run_id, steps.episode_id == episodes.episode_id)
            .scalar_subquery()
        )
        query = sa.select(episodes.run_id, episodes.episode_id, episodes.epoch, last).where(episodes.state == OPEN)
        rows = self._database.read(query)
        return {(run, episode): (epoch, 0 if step is None else step + 1) for run, episode, epoch, step in rows}

    def wait_for_steps(self) -> None:
        """Waits until something new is recorded."""
        before = self.open_episodes()
        for _ in self._looks():
            now = self.open_episodes()
            if any(steps > before.get(episode, (0, 0))[1] for episode, (_, steps) in now.items()):
                return

    def wait_for_return(self, lost: Steps) -> bool:
        """Waits until a step is recorded of an episode that was open when a process died and was claimed anew since.

        Returns:
            Whether there was one: not where the process that died held nothing.
        """
        for _ in self._looks():
            now = self.open_episodes()
            shared = [(lost[episode], now[episode]) for episode in lost.keys() & now.keys()]
            if any(later > earlier and steps > before for (earlier, before), (later, steps) in shared):
                return True
            if all(later == earlier and steps > before for (earlier, before), (later, steps) in shared):
                return False
        raise AssertionError("the looks end by themselves")

    def revive(self) -> None:
        """Starts hosts again that ended because a worker died again and again, as a host's supervisor does."""
        for host in self.hosts:
            if host not in self.away and host.process.poll() is not None:
                self.given_up += 1
                host.process.communicate()
                host.start()

    def _looks(self) -> Iterator[None]:
        """Moments at which to look whether what is waited for is there."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            yield
            self.revive()
            time.sleep(0.01)
        raise Stuck(f"no step was recorded in {PATIENCE:.0f} seconds")


@contextmanager
def service(kind: str, workers: int, folder: Path) -> Iterator[Service]:
    """Starts everything on the loopback, and stops it.

    Args:
        kind: of the database, sqlite or postgresql.
        workers: processes of each host.
        folder: for the hosts' data.
    """
    with ExitStack() as stack:
        cluster = stack.enter_context(running_cluster()) if kind == "postgresql" else None
        url = cluster.create() if cluster else f"sqlite:///{folder / 'journal.db'}"
        shared = ["--journal", url, "--signing-key", str(folder / "key.pem"), "--workers", str(workers)]
        shared += ["--drain-seconds", "5"]
        hosts = list[Server]()
        for listen in ("127.0.0.2:0", "127.0.0.3:0") if cluster else ("127.0.0.1:0",):
            data = folder / f"host-{len(hosts)}"
            tiny.write(data, count=EPISODES)
            hosts.append(Server(data, listen, *shared, log=folder / f"log-{len(hosts)}"))
            stack.callback(_end, hosts[-1])
        database = stack.enter_context(closing(Database(url)))
        yield Service(hosts, url, cluster, database)


def _end(host: Server) -> None:
    """Stops a host, whatever state it is in."""
    if host.process.poll() is None:
        for process in (host.process.pid, *children(host.process.pid)):
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGCONT)
        host.stop()


class Faults:
    """Makes faults, one at a time; each method says what it did.

    Args:
        service: to be disturbed.
        players: likewise.
        chance: draws who is hit, and for how long.
        folder: for the results of second clients.

    Attributes:
        times: seconds from each kill that hit a process with open episodes to the next step of one of these.
        seconds: the clients that were started to play another's run.
        complaints: what was not as it should be.
    """

    def __init__(self, service: Service, players: Sequence[Player], chance: random.Random, folder: Path) -> None:
        self._service, self._players, self._chance, self._folder = service, players, chance, folder
        self.times: list[float] = []
        self.seconds: list[Player] = []
        self.complaints: list[str] = []

    def kill_server(self) -> str:
        """SIGKILL to a worker, or to all processes of a host."""
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
            else:  # it stays away until others have taken over; then a player is sent back to it
                self._service.away.append(host)
        returned = self._service.wait_for_return(lost)
        if returned:
            self.times.append(time.monotonic() - at)
        while self._service.away:
            self._service.away.pop().start()
            self._send(self._chance.choice(self._players), host)
        what = "a worker" if one else f"the host at {host.address}"
        return f"{what}; " + (f"played on after {self.times[-1]:.2f} s" if returned else "it played nothing")

    def stop_server(self) -> str:
        """SIGTERM, as for an upgrade, and a new start."""
        host = self._host()
        self._leave(host)
        if status := host.stop():
            self.complaints.append(f"the host at {host.address} was stopped and ended with status {status}")
        host.start()
        return f"the host at {host.address}"

    def pause_server(self) -> str:
        """A process stands still; where there is another host, that takes over what it holds."""
        host, seconds = self._host(), self._chance.uniform(0.5, 8.0)
        process = self._chance.choice(children(host.process.pid) or [host.process.pid])
        pause(process, None if self._service.cluster else Path(self._service.url.removeprefix("sqlite:///")))
        self._leave(host)
        time.sleep(seconds)
        os.kill(process, signal.SIGCONT)
        return f"a process of the host at {host.address}, for {seconds:.1f} s"

    def kill_client(self) -> str:
        """SIGKILL; it is started again with --resume."""
        player = self._player()
        player.signal(signal.SIGKILL)
        self._until_back(player)
        return f"in run {player.run}"

    def pause_client(self) -> str:
        """It stands still, and goes on."""
        player, seconds = self._player(), self._chance.uniform(0.5, 4.0)
        player.signal(signal.SIGSTOP)
        time.sleep(seconds)
        player.signal(signal.SIGCONT)
        return f"for {seconds:.1f} s"

    def double_client(self) -> str:
        """Another client plays the same run at the same time, to its end."""
        run = self._player().run
        second = Player(self._host().address, self._folder / f"second-{len(self.seconds)}")
        self.seconds.append(second.start(run))
        return f"run {run}"

    def reset(self) -> str:
        """Every connection of a player is reset, as by a proxy that restarts."""
        player = self._player()
        before = player.relay.resets
        player.relay.reset()
        self._until_back(player)
        return f"{player.relay.resets - before} of them"

    def silence(self) -> str:
        """Nothing passes for a while, and nobody is told; then all of it."""
        relay, seconds = self._player().relay, self._chance.uniform(0.5, 4.0)
        relay.freeze()
        time.sleep(seconds)
        relay.thaw()
        return f"for {seconds:.1f} s"

    def fill_disk(self) -> str:
        """No file of the server can grow for a while."""
        host, seconds = self._host(), self._chance.uniform(0.3, 2.0)
        processes = [host.process.pid, *children(host.process.pid)]
        for limits in (FULL, (resource.RLIM_INFINITY, resource.RLIM_INFINITY)):
            for process in processes:
                resource.prlimit(process, resource.RLIMIT_FSIZE, limits)
            if limits is FULL:
                time.sleep(seconds)
        return f"for {seconds:.1f} s"

    def end_database(self) -> str:
        """PostgreSQL crashes, or is stopped, and comes back."""
        cluster, seconds, crash = self._service.cluster, self._chance.uniform(0.0, 3.0), self._chance.random() < 0.5
        assert cluster is not None
        if crash:
            cluster.crash()
        else:
            cluster.stop()
        time.sleep(seconds)
        cluster.start()
        return f"{'by a crash' if crash else 'in good order'}, for {seconds:.1f} s"

    def _host(self) -> Server:
        """One to which a player's way leads."""
        target = self._chance.choice(self._players).relay.target
        return next(host for host in self._service.hosts if host.address == target)

    def _player(self) -> Player:
        """One that plays, once there is one."""
        for _ in range(int(PATIENCE / 0.02)):
            playing = [player for player in self._players if player.is_playing]
            if playing:
                return self._chance.choice(playing)
            time.sleep(0.02)
        raise Stuck(f"no client has begun a run in {PATIENCE:.0f} seconds")

    def _until_back(self, player: Player) -> None:
        """Waits until a player whose connection broke goes on with what it had: the next kill's time is its own."""
        mine = {episode: known for episode, known in self._service.open_episodes().items() if episode[0] == player.run}
        self._service.wait_for_return(mine)

    def _leave(self, host: Server) -> None:
        """Where there are several hosts, the clients' ways lead to another one, as behind a proxy that knows."""
        others = [each for each in self._service.hosts if each is not host]
        for player in (*self._players, *self.seconds):
            if others and player.relay.target == host.address:
                self._send(player, self._chance.choice(others))

    @staticmethod
    def _send(player: Player, host: Server) -> None:
        player.relay.target = host.address
        player.relay.reset()


class Fault(NamedTuple):
    """A kind of fault."""

    name: str
    make: Callable[[Faults], str]


KILL = Fault("server killed", Faults.kill_server)

OTHERS = (
    Fault("client killed", Faults.kill_client),
    Fault("client stood still", Faults.pause_client),
    Fault("a second client played the run", Faults.double_client),
    Fault("connections reset", Faults.reset),
    Fault("connections fell silent", Faults.silence),
    Fault("server stood still", Faults.pause_server),
    Fault("server stopped in good order", Faults.stop_server),
)
"""Those of every arrangement."""

OF_DATABASE = {
    "sqlite": Fault("disk full", Faults.fill_disk),
    "postgresql": Fault("database ended", Faults.end_database),
}
