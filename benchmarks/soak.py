"""Nothing is lost: clients play run after run while faults hit everything, and every run ends as an undisturbed one.

    python benchmarks/soak.py [--kills 100] [--database sqlite|postgresql] [--workers N] [--seed S] [--json FILE]

SQLite: one host. PostgreSQL: two hosts that share one, and clients whose way leads to either. Between two kills of the
server another fault may be made. The seed decides which, whom and how long; the moment in the play is the machine's.
The agent's actions are a function of episode and step. At the end every run is compared with the undisturbed one:
scores, causes, actions in the journal, the receipt, and what comes out when the journal is played again.
Exit status 1 where anything differs, or was not finished in time.
"""

import argparse
import contextlib
import io
import itertools
import json
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests make the same faults, one by one

from soak_players import Player
from soak_service import KILL, OF_DATABASE, OTHERS, Fault, Faults, Service, Stuck, service

from arramon_client import verify
from tests.faults.clients import differences, undisturbed

SHARE_OF_OTHERS = 0.6
"""Chance of another fault after a kill."""


def plan(kills: int, kind: str, seed: int) -> Iterator[Fault]:
    """The faults in their order."""
    chance = random.Random(seed)  # noqa: S311 - the same faults for a seed
    others = (*OTHERS, OF_DATABASE[kind])
    for _ in range(kills):
        yield KILL
        if chance.random() < SHARE_OF_OTHERS:
            yield chance.choice(others)


class Soak:
    """One soak on a service that runs.

    Attributes:
        made: how many faults of each kind.
        stuck: what was not done in time.
    """

    def __init__(self, there: Service, options: argparse.Namespace, folder: Path) -> None:
        self._there, self._options, self._folder = there, options, folder
        self._chance = random.Random(options.seed)  # noqa: S311 - the same faults for a seed
        addresses = itertools.islice(itertools.cycle(host.address for host in there.hosts), options.clients)
        self._players = [Player(address, folder / f"player-{number}") for number, address in enumerate(addresses)]
        self._faults = Faults(there, self._players, self._chance, folder)
        self.made, self.stuck = Counter[str](), list[str]()

    def close(self) -> None:
        """Leaves no client running."""
        with ExitStack() as stack:  # whatever goes wrong with one, the others are closed too
            for player in self._everyone:
                stack.callback(player.close)

    @property
    def _everyone(self) -> list[Player]:
        return [*self._players, *self._faults.seconds]

    def disturb(self, until: float) -> None:
        """Has the players play, and makes the faults, until they are through or time is up; then ends the play."""
        for player in self._players:
            player.start()
        try:
            for fault in plan(self._options.kills, self._options.database, self._options.seed):
                if time.monotonic() > until:
                    self.stuck.append(f"time was up after {self.made[KILL.name]} of {self._options.kills} kills")
                    break
                self._there.wait_for_steps()
                time.sleep(self._chance.uniform(0.0, 0.5))
                said = fault.make(self._faults)
                self.made[fault.name] += 1
                print(f"{sum(self.made.values()):4} {fault.name}: {said}", flush=True)
        except Stuck as error:
            self.stuck.append(str(error))
        print("no more faults; the last runs are played to their end ...", flush=True)
        for player in self._everyone:
            player.end()
        end = time.monotonic() + self._options.patience
        left = [player for player in self._everyone if not player.wait(end - time.monotonic())]
        self.stuck += [f"run {player.run or '?'} was not finished" for player in left]

    def figures(self, once: Any) -> dict[str, Any]:
        """What came out, every run compared with the undisturbed one."""
        played = [(player, run) for player in self._everyone for run in player.finished]
        print(f"comparing {len(played)} runs with the undisturbed one ...", flush=True)
        wrong = [f"run {run}: {text}" for player, run in played for text in compare(self._there, once, player, run)]
        wrong += rescore(self._there, [once["run"]["run_id"], *{run for _, run in played}])
        complaints = [text for player in self._everyone for text in player.complaints]
        complaints += [*self.stuck, *self._faults.complaints]
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
            "hosts started again as a whole": self._there.given_up,
            "mismatches": len(wrong),
            "other complaints": len(complaints),
            "said": [*wrong, *complaints],
        }


def compare(there: Service, once: Any, player: Player, run: str) -> Iterator[str]:
    """What is not as in the undisturbed run, and what is wrong with the receipt."""
    yield from differences(there.url, once, player.results(run))
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = verify.main([str(player.receipt(run)), "--server", there.hosts[0].address])
    if status:
        yield f"its receipt: {said.getvalue().strip()}"


def rescore(there: Service, runs: Sequence[str]) -> list[str]:
    """Plays the journal again; what comes out otherwise, in words."""
    command = [sys.executable, "-m", "server", "rescore", "--data", str(there.data), "--journal", there.url, *runs]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if not line.endswith(": identical")]
    if done.returncode and not lines:
        lines = [done.stderr.strip()]
    return [f"played again: {line}" for line in lines]


def show(figures: dict[str, Any]) -> None:
    """Prints the table."""
    rows = {**figures, **{f"fault: {name}": number for name, number in figures["faults"].items()}}
    times = rows.pop("seconds to resume")
    if times:
        rows["seconds to resume, p50"] = f"{statistics.median(times):.2f}"
        rows["seconds to resume, max"] = f"{times[-1]:.2f}"
    for text in rows.pop("said"):
        print(f"WRONG: {text}")
    del rows["faults"]
    for name, value in rows.items():
        print(f"{name:40} {value:>10}")


def main() -> int:
    """Runs the soak; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    add = parser.add_argument
    add("--kills", type=int, default=100, help="of server processes (default: %(default)s)")
    add("--database", choices=sorted(OF_DATABASE), default="sqlite", help="(default: %(default)s)")
    add("--workers", type=int, default=1, help="processes of each host (default: %(default)s)")
    add("--clients", type=int, default=3, help="that play at once, each its own runs (default: %(default)s)")
    add("--seed", type=int, default=1, help="of the faults (default: %(default)s)")
    add("--minutes", type=float, default=60.0, help="after which no more faults are made (default: %(default)s)")
    add("--patience", type=float, default=300.0, help="seconds for the last runs to end (default: %(default)s)")
    add("--json", type=Path, help="file for the figures")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that everything is stopped on the way
    started = time.monotonic()
    try:
        with tempfile.TemporaryDirectory(prefix="arramon-soak-") as name:
            folder = Path(name)
            with service(options.database, options.workers, folder) as there:
                print("an undisturbed run ...", flush=True)
                once = undisturbed(there.hosts[0], folder / "undisturbed")
                with closing(Soak(there, options, folder)) as soak:
                    soak.disturb(started + 60.0 * options.minutes)
                    figures = soak.figures(once)
    except pytest.skip.Exception as missing:  # how the tests say that there is no PostgreSQL
        parser.error(str(missing))
    except KeyboardInterrupt:
        print("interrupted")
        return 130
    settings = {name: getattr(options, name) for name in ("database", "workers", "clients", "seed")}
    figures = {**settings, **figures, "minutes": round((time.monotonic() - started) / 60.0, 1)}
    show(figures)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))
    return int(bool(figures["mismatches"] or figures["other complaints"]))


if __name__ == "__main__":
    sys.exit(main())
