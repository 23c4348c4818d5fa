"""Soak test: clients play run after run under faults of all kinds, and every run must equal an undisturbed one.

    python -m benchmarks.soak.run [--kills 100] [--database sqlite|postgresql] [--workers N] [--seed S] [--json FILE]
    python -m benchmarks.soak.run --hosted --database postgresql --clients 4 --kills 20 --rude 300 --spread 15

SQLite: one host. PostgreSQL: two hosts that share a database, and clients that connect to either. Between two kills of
the server another fault may be injected. The seed determines its kind, target and duration, but not its exact moment.
The agent's actions are a function of episode and step. At the end every run is compared with an undisturbed one that an
embedded server played: scores, causes, actions in the journal, the receipt, and the result of a replay of the journal.
With --hosted the servers have a host's settings (TLS, tokens, limits, log at `info`), the agents get images, and
warnings in a log that no injected fault explains are failures. --rude adds streams that end without a proper close.
Exits with status 1 if anything differs, was not finished in time, or a server exited on its own.
"""

import argparse
import contextlib
import io
import itertools
import random
import signal
import statistics
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

import arramon_server.cli
from arramon_client.commands import verify
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage.database import Database
from benchmarks.common import add_json, parser_of, write_json
from benchmarks.soak.logs import unexplained, warnings
from benchmarks.soak.players import SoakPlayer
from benchmarks.soak.rude import RudeStreams
from benchmarks.soak.service import (
    AUTHORITY,
    KILL,
    OF_DATABASE,
    OTHERS,
    FaultInjector,
    FaultKind,
    NoProgress,
    SoakService,
    service,
)
from tests import tiny
from tests.faults.clients import EPISODES, UndisturbedRun, client, differences, finish, journal_url, results

IMAGE_ARGUMENTS = ("--sensors", "rgb,depth", "--image-size", "128", "--parallel", "8")
"""Arguments of players on servers with a host's settings: they get images, and leave episodes to rude streams."""

OTHER_FAULT_PROBABILITY = 0.6
"""Probability of another fault after a kill."""


def plan(kills: int, kind: str, seed: int) -> Iterator[FaultKind]:
    """Yield the faults in order."""
    chance = random.Random(seed)  # noqa: S311 - the same faults for a seed
    others = (*OTHERS, OF_DATABASE[kind])
    for _ in range(kills):
        yield KILL
        if chance.random() < OTHER_FAULT_PROBABILITY:
            yield chance.choice(others)


class SoakTest:
    """A soak test of a running service.

    Attributes:
        made: number of injected faults by kind.
        stuck: descriptions of work that did not finish in time.
    """

    def __init__(self, soak_service: SoakService, options: argparse.Namespace, folder: Path) -> None:
        self._service, self._options, self._folder = soak_service, options, folder
        self._chance = random.Random(options.seed)  # noqa: S311 - the same faults for a seed
        addresses = itertools.islice(itertools.cycle(host.address for host in soak_service.hosts), options.clients)
        self._players = [
            SoakPlayer(address, folder / f"player-{number}", access, IMAGE_ARGUMENTS if options.hosted else ())
            for number, address in enumerate(addresses)
            for access in (credentials(soak_service, folder, f"team-{number}", options.hosted),)
        ]
        seconds = 60.0 * (options.spread or 0.2)
        self._rude = RudeStreams(self._players, self._shown, options.rude, seconds, random.Random(options.seed))  # noqa: S311
        self._faults = FaultInjector(soak_service, self._players, self._chance, folder)
        self.made, self.stuck = Counter[str](), list[str]()
        self._started = time.monotonic()

    def close(self) -> None:
        """Stop all clients."""
        with ExitStack() as stack:  # an error with one does not keep the others open
            for player in self._everyone:
                stack.callback(player.close)
            stack.callback(self._rude.close)

    @staticmethod
    def _shown(player: SoakPlayer) -> Sequence[str]:
        """Return the files of a player's token and of the authority, if any."""
        return player.access[1::2]

    @property
    def _everyone(self) -> list[SoakPlayer]:
        return [*self._players, *self._faults.seconds]

    def disturb(self, until: float) -> None:
        """Start the players and inject faults until all are done or time is up; then let the last runs finish."""
        for player in self._players:
            player.start()
        self._rude.start()
        faults = list(plan(self._options.kills, self._options.database, self._options.seed))
        rest = 60.0 * self._options.spread / len(faults) if faults else 0.0
        try:
            for number, fault in enumerate(faults):
                self._service.wait_and_revive(self._started + number * rest - time.monotonic())
                if time.monotonic() > until:
                    self.stuck.append(f"out of time after {self.made[KILL.name]} of {self._options.kills} kills")
                    break
                self._service.wait_for_steps()
                time.sleep(self._chance.uniform(0.0, 0.5))
                said = fault.make(self._faults)
                self.made[fault.name] += 1
                print(f"{sum(self.made.values()):4} {fault.name}: {said}", flush=True)
            self._rude.wait()
        except NoProgress as error:
            self.stuck.append(str(error))
        print("no more faults; waiting for the last runs to end ...", flush=True)
        for player in self._everyone:
            player.end()
        end = time.monotonic() + self._options.patience
        left = [player for player in self._everyone if not player.wait(end - time.monotonic())]
        self.stuck += [f"run {player.run or '?'} was not finished" for player in left]

    def figures(self, once: UndisturbedRun) -> dict[str, Any]:
        """Compare every run with the undisturbed one, and return the results."""
        played = [(player, run) for player in self._everyone for run in player.finished]
        print(f"comparing {len(played)} runs with the undisturbed one ...", flush=True)
        wrong = [f"run {run}: {text}" for player, run in played for text in compare(self._service, once, player, run)]
        wrong += rescore(self._service, sorted({run for _, run in played})) if played else ["no run was finished"]
        complaints = [text for player in self._everyone for text in player.complaints]
        complaints += [*self.stuck, *self._faults.complaints]
        if sum(self._rude.ended.values()) < self._options.rude:
            complaints.append(f"only {sum(self._rude.ended.values())} streams ended rudely")
        runs = {run: player.results(run) for player, run in played}
        return {
            "faults": dict(self.made),
            "kills that hit a process that played": len(self._faults.times),
            "seconds to resume": sorted(self._faults.times),
            "runs": len(runs),
            "episodes": sum(len(each["episodes"]) for each in runs.values()),
            "steps": sum(each["run"]["steps"] for each in runs.values()),
            "episodes offered again": sum(int(each["run"]["reoffers"]) for each in runs.values()),
            "clients that found no server": sum(player.refusals for player in self._everyone),
            "minutes of play": round(sum(player.seconds for player in self._everyone) / 60.0, 1),
            "streams ended rudely": sum(self._rude.ended.values()),
            "of these, by way": dict(self._rude.ended),
            "further ones that were refused": dict(self._rude.refused),
            "mismatches": len(wrong),
            "said": [*wrong, *complaints],
        }


def collect_exits_and_warnings(
    soak_service: SoakService, options: argparse.Namespace, folder: Path, faults: Sequence[str]
) -> dict[str, Any]:
    """Return the exit statuses of the stopped servers, and their logged warnings."""
    # Of several workers, all may have been killed too often in a row: then their host exits with status 1.
    wrong = [status for status in soak_service.exits if status != 1 or options.workers == 1]
    said = [f"a server exited on its own with status {status}" for status in wrong]
    logged = warnings(folder) if options.hosted else Counter[str]()
    said += [f"no fault explains in a log: {text}" for text in unexplained(logged, faults)]
    return {
        "hosts started again as a whole": len(soak_service.exits) - len(wrong),
        "warnings and errors in the logs": dict(logged),
        "said": said,
    }


def embedded(folder: Path) -> UndisturbedRun:
    """Play undisturbed, with an embedded server on the same episodes."""
    tiny.write(folder / "data", count=EPISODES)
    finish(client(None, folder / "results", "--data", str(folder / "data")))
    return UndisturbedRun(results(folder / "results"), journal_url(folder / "data"))


def credentials(soak_service: SoakService, folder: Path, participant: str, hosted: bool) -> Sequence[str]:
    """Return a participant's client arguments: files of a new token and of the authority; none without --hosted."""
    if not hosted:
        return ()
    token = folder / f"token-{participant}"
    with closing(Database(soak_service.url)) as database:
        token.write_text(Accounts(database).create_token(participant, Role.PARTICIPANT))
    return "--token-file", str(token), "--tls-ca", str(folder / AUTHORITY)


def compare(soak_service: SoakService, once: UndisturbedRun, player: SoakPlayer, run: str) -> Iterator[str]:
    """Yield the differences from the undisturbed run, and the errors of the receipt."""
    yield from differences(soak_service.url, once.results, player.results(run), once_url=once.url)
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = verify.main([str(player.receipt(run)), "--server", soak_service.hosts[0].address, *player.access])
    if status:
        yield f"its receipt: {said.getvalue().strip()}"


def rescore(soak_service: SoakService, runs: Sequence[str]) -> list[str]:
    """Replay the journal; return descriptions of the differences."""
    said, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(errors):
        status = arramon_server.cli.main(
            ["rescore", "--data", str(soak_service.data), "--journal", soak_service.url, *runs]
        )
    lines = [line for line in said.getvalue().splitlines() if not line.endswith(": identical")]
    if status and not lines:
        lines = [errors.getvalue().strip()]
    return [f"replayed: {line}" for line in lines]


def show(figures: dict[str, Any]) -> None:
    """Print the table."""
    rows = {**figures, **{f"fault: {name}": number for name, number in figures["faults"].items()}}
    times = rows.pop("seconds to resume")
    if times:
        rows["seconds to resume, p50"] = f"{statistics.median(times):.2f}"
        rows["seconds to resume, max"] = f"{times[-1]:.2f}"
    for text in rows.pop("said"):
        print(f"WRONG: {text}")
    del rows["faults"]
    for name, value in rows.items():
        if isinstance(value, dict):
            print(f"{name:40}", *(f"\n{number:>8} {what}" for what, number in value.items()))
        else:
            print(f"{name:40} {value:>10}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the soak test; return the exit status."""
    parser = parser_of(__doc__)
    add = parser.add_argument
    add("--kills", type=int, default=100, help="number of kills of server processes (default: %(default)s)")
    add(
        "--database",
        choices=sorted(OF_DATABASE),
        default="sqlite",
        help="the journal's database (default: %(default)s)",
    )
    add("--workers", type=int, default=1, help="processes of each host (default: %(default)s)")
    add("--clients", type=int, default=3, help="concurrent clients, each with its own runs (default: %(default)s)")
    add("--seed", type=int, default=1, help="seed of the faults (default: %(default)s)")
    add(
        "--minutes",
        type=float,
        default=60.0,
        help="time after which no more faults are injected (default: %(default)s)",
    )
    add("--patience", type=float, default=300.0, help="seconds for the last runs to end (default: %(default)s)")
    add("--hosted", action="store_true", help="TLS, tokens, limits and a log at `info`")
    add("--rude", type=int, default=0, help="number of streams that end without a proper close (default: %(default)s)")
    add("--spread", type=float, default=0.0, help="minutes over which the faults are spread (default: no pauses)")
    add_json(parser)
    options = parser.parse_args(argv)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that everything is stopped on exit
    started = time.monotonic()
    try:
        with tempfile.TemporaryDirectory(prefix="arramon-soak-") as name:
            folder = Path(name)
            print("an undisturbed run ...", flush=True)
            once = embedded(folder / "embedded")
            with (
                service(options.database, options.workers, folder, hosted=options.hosted) as soak_service,
                closing(SoakTest(soak_service, options, folder)) as soak,
            ):
                soak.disturb(started + 60.0 * options.minutes)
                figures = soak.figures(once)
            ended = collect_exits_and_warnings(soak_service, options, folder, [*figures["faults"]])
            figures |= {**ended, "said": [*figures["said"], *ended["said"]]}
    except pytest.skip.Exception as missing:  # raised by the tests if PostgreSQL is missing
        parser.error(str(missing))
    except KeyboardInterrupt:
        print("interrupted")
        return 130
    settings = {name: getattr(options, name) for name in ("database", "workers", "clients", "seed", "hosted")}
    figures = {**settings, **figures, "minutes": round((time.monotonic() - started) / 60.0, 1)}
    show(figures)
    write_json(options.json, figures)
    return int(bool(figures["said"]))


if __name__ == "__main__":
    sys.exit(main())
