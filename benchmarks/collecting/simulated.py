"""Simulates a collection: scripted people write and verify in Chromium while the server is killed; checks the result.

    python -m benchmarks.collecting.simulated --data arramon-data --split val_unseen --episodes 30

In each language some writers write the episode's own text, one that of another episode, one pastes, and one leaves in
the middle; verifiers follow what a text says, and one gives up at once. A host accepts what is in review. Then the kept
texts and the ledger are compared with what follows from who wrote and verified what, the collection is exported, and
an agent plays the exported split.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from arramon_collecting.settings import Settings
from arramon_collecting.storage.store import Store
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.runs.storage.database import Database
from benchmarks.collecting.host_server import HostServer
from benchmarks.collecting.people import HostPerson, Person, Texts, Verifier, Writer

SETTINGS = """
min_seconds_write = 0
min_seconds_verify = 1
gold_share = 0.0
task_minutes = 1
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the simulation; return 1 if its result is not what follows from the script."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.collecting.simulated", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="data folder with the split; it is not changed")
    parser.add_argument("--split", default="val_unseen", help="its name (default: %(default)s)")
    parser.add_argument("--langs", default="en,hi", help="languages (default: %(default)s)")
    parser.add_argument("--episodes", type=int, default=30, help="episodes in each language (default: %(default)s)")
    parser.add_argument("--kills", type=int, default=4, help="kills of the server (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the kills (default: %(default)s)")
    parser.add_argument("--agent", default="agents.vl_map", help="plays the exported splits (default: %(default)s)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder for the collection's data (default: deleted)")
    options = parser.parse_args(argv)
    chromium = shutil.which("chromium")
    if chromium is None:
        parser.error("there is no `chromium` on this machine")
    with tempfile.TemporaryDirectory(prefix="arramon-collecting-") as unnamed, sync_playwright() as playwright:
        data = options.keep or Path(unnamed)
        shutil.copytree(split_folder(options.data, options.split), split_folder(data, options.split))
        (data / "collection.toml").write_text(SETTINGS)
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        server = HostServer(data, options.kills, options.seed)
        simulation = Simulation(data, read_split(split_folder(data, options.split)), server, browser)
        try:
            problems = simulation.run(options.langs.split(","), options.episodes)
        finally:
            server.stop()
            browser.close()
        for language in options.langs.split(","):
            problems += _export_and_play(data, f"sim-{language}", language, options.agent)
    for problem in problems:
        print(f"WRONG: {problem}")
    print("all as it should be" if not problems else f"{len(problems)} problems")
    return 1 if problems else 0


class Simulation:
    """The simulation on one server.

    Args:
        data: data folder with the split and `collection.toml`.
        split: the split that is written for.
        server: the server, not yet started.
        browser: in which everybody has a window.
    """

    def __init__(self, data: Path, split: Split, server: HostServer, browser: Browser) -> None:
        self._data, self._split, self._server, self._browser = data, split, server, browser

    def run(self, languages: Sequence[str], episodes: int) -> list[str]:
        """Run a collection in each language; return what is not as it should be."""
        for language in languages:
            words = ["--split", self._split.name, "--lang", language, "--episodes", str(episodes)]
            _command(
                "collect", "create", f"sim-{language}", *words, "--settings", str(self._data / "collection.toml"),
                data=self._data,
            )  # fmt: skip
        self._server.start()
        problems = []
        with closing(Database(f"sqlite:///{self._data / 'journal.db'}")) as database:
            store = Store(database)
            for language in languages:
                begun = time.monotonic()
                people = self._people(language)
                self._work(store, people)
                print(f"{language}: {time.monotonic() - begun:.0f} s, {self._server.kills_left} kills left")
                problems += self._check(store, language, people)
                for person in people:
                    person.context.close()
        if self._server.kills_left:
            problems.append(f"{self._server.kills_left} kills did not happen")
        return problems

    def _people(self, language: str) -> list[Person]:
        own = {one.episode_id: _texts(one, language) for one in self._split.episodes.values()}
        ids = sorted(own)

        def other(_: int, episode: str) -> Texts:
            return own[ids[(ids.index(episode) + 1) % len(ids)]]

        def right(_: int, episode: str) -> Texts:
            return own[episode]

        known = {
            text: (episode, number)
            for episode in self._split.episodes.values()
            for number, text in enumerate(own[episode.episode_id])
        }
        links = {role: self._links(language, role, count) for role, count in (("worker", 13), ("host", 1))}
        link = iter(links["worker"])
        common: dict[str, object] = {"server": self._server, "browser": self._browser, "language": language}

        def writer(name: str, say: object, **more: object) -> Writer:
            return Writer(name=name, link=next(link), say=say, **common, **more)  # type: ignore[arg-type]

        def verifier(name: str, **more: object) -> Verifier:
            return Verifier(name=name, link=next(link), known=known, **common, **more)  # type: ignore[arg-type]

        people: list[Person] = [
            writer("leaves", right, leaves=True),
            *(writer(f"careful writer {number}", right) for number in (1, 2, 3)),
            writer("careless writer", other),
            writer("pastes", right, pastes=True),
            *(verifier(f"careful verifier {number}") for number in range(1, 7)),
            verifier("hasty verifier", is_hasty=True),
            HostPerson(name="host", link=links["host"][0], **common),  # type: ignore[arg-type]
        ]
        for person in people:
            person.join()
        return people

    def _links(self, language: str, role: str, count: int) -> list[str]:
        words = ["--count", str(count), "--role", role, "--site", self._server.site]
        return _command("collect", "invite", f"sim-{language}", *words, data=self._data).split()

    def _work(self, store: Store, people: Sequence[Person]) -> None:
        """Let everybody work in turns until nobody finds a task any more, also after the one who left was given up."""
        idle_since = None
        while idle_since is None or time.monotonic() - idle_since < 75:
            found = False
            for person in people:
                match person:
                    case Writer():
                        found |= person.work(lambda task: store.tasks.get(task).episode_id)
                    case Verifier() | HostPerson():
                        found |= person.work()
            if found:
                idle_since = None
            else:
                idle_since = idle_since or time.monotonic()
                time.sleep(5)

    def _check(self, store: Store, language: str, people: Sequence[Person]) -> list[str]:
        """Return what differs from what follows from the script."""
        name = f"sim-{language}"
        settings = store.collections.get(name).settings
        texts = store.texts.all(name)
        problems = [f"{person.name}: {mishap}" for person in people for mishap in person.mishaps]
        for text in texts:
            episode = self._split.episodes[text.episode_id]
            said = tuple(part for pair in text.instructions for part in pair)
            expected = "kept" if said == _texts(episode, language) else "discarded"
            if text.state != expected:
                problems.append(f"{name}: text of episode {text.episode_id} is {text.state}, expected {expected}")
        written = sum(person.tasks for person in people if isinstance(person, Writer))
        if len(texts) != written:
            problems.append(f"{name}: {len(texts)} texts, expected {written}")
        states = Counter(text.state for text in texts)
        paid, owed = store.ledger.total(name), _owed(settings, people, states["kept"])
        if paid != owed:
            problems.append(f"{name}: {settings.money(paid)} in the ledger, expected {settings.money(owed)}")
        given_back = sum(person.given_back for person in people if isinstance(person, Writer))
        pasted = sum(bool(text.evidence) for text in texts)
        print(f"{name}: {dict(states)}, {settings.money(paid)}, pasted texts: {pasted}, tasks given back: {given_back}")
        return problems


def _owed(settings: Settings, people: Sequence[Person], kept: int) -> int:
    """Return what the people have earned: from what they did, not from what was stored."""
    owed = kept * settings.pay_kept
    for person in people:
        match person:
            case Writer():
                owed += person.tasks * settings.pay_write
                owed += sum(amount for count, amount in settings.milestones.items() if person.tasks >= count)
            case Verifier() if not person.is_hasty:
                owed += person.tasks * settings.pay_verify
    return owed


def _texts(episode: Episode, language: str) -> Texts:
    first, second = episode.instructions[language]
    return first.navigation, first.assembly, second.navigation, second.assembly


def _export_and_play(data: Path, name: str, language: str, agent: str) -> list[str]:
    print(_command("collect", "export", name, data=data).strip())
    exported = read_split(split_folder(data, name))
    answer = subprocess.run(
        [sys.executable, "-m", "arramon_client", "--agent", agent, "--lang", language, "--data", str(data),
         "--split", name, "--output", str(data / "results"), "--quiet", "--json"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if answer.returncode:
        return [f"{agent} cannot play {name}: {answer.stderr.strip()}"]
    results: Mapping[str, object] = json.loads(answer.stdout)
    print(f"{name}: {len(exported.episodes)} episodes, {agent}: {json.dumps(results, ensure_ascii=False)[:400]}")
    return []


def _command(*words: str, data: Path) -> str:
    """Run `arramon-server` on the data folder; return what it prints."""
    command = [sys.executable, "-m", "arramon_server", *words, "--data", str(data)]
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout


if __name__ == "__main__":
    sys.exit(main())
