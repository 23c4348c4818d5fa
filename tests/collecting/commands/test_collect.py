"""The command `collect`, from a new collection to an exported split that is played."""

import csv
import json
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from arramon_client.cli import main as client
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.work.submissions import Play
from arramon_dataset.release.files import read_release
from arramon_server.cli import main
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.runs.storage.database import Database
from tests import forked, tiny
from tests.collecting.collecting import TEXTS, WELL

SETTINGS = """
[collections.street]
min_seconds_write = 0
gold_share = 0.0
licence = "CC0-1.0"
"""


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data folder with a split, and a settings file."""
    tiny.write(tmp_path / "data", count=6)
    (tmp_path / "arramon.toml").write_text(f'data = "{tmp_path / "data"}"\nweb = "127.0.0.1:8080"\n{SETTINGS}')
    monkeypatch.setenv("ARRAMON_CONFIG", str(tmp_path / "arramon.toml"))
    return tmp_path / "data"


@contextmanager
def store(data: Path) -> Iterator[Store]:
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        yield Store(database)


def created(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", "create", "street", "--split", "tiny", "--lang", "en"]) == 0
    assert capsys.readouterr().out == "collection street: write, en, 6 episodes of tiny\n"


def collect(data: Path, episodes: list[str]) -> list[str]:
    """Let two people write, and three verify; return the ids of the people."""
    with store(data) as opened:
        collection = opened.collections.get("street")
        people = []
        for _ in range(5):
            invited, _ = opened.workers.invite(collection)
            opened.workers.consent(invited, collection, keep_texts=True)
            people.append(opened.workers.get(invited.worker_id))
        for number, _ in enumerate(episodes):
            task = opened.tasks.claim_write(collection, people[number % 2], episodes)
            assert task is not None
            opened.submissions.submit_text(collection, task, "s", TEXTS)
        for verifier in people[2:]:
            while (task := opened.tasks.claim_verify(collection, verifier, ())) is not None:
                scores = WELL if task.episode_id != "4" else (0.0, 0.0)
                play = Play("", scores, (1.0, 1.0), (None, None), ((), ()), (), 60.0)
                opened.submissions.submit_verification(collection, task, "s", play)
    return [person.worker_id for person in people]


def test_the_settings_are_those_of_the_file(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    with store(data) as opened:
        settings = opened.collections.get("street").settings
    assert (settings.min_seconds_write, settings.licence, settings.pay_write) == (0, "CC0-1.0", 100)


@pytest.mark.parametrize(
    ("settings", "is_said"),
    [
        ("", False),
        ("consent = 'Mine.'", True),
        ("consent = 'Mine.'\nconsent_in = {hi = 'मेरा।'}", False),
        ("consent = 'Mine.'\npage_languages = ['en']", False),
    ],
)
def test_a_missing_consent_text_is_said(
    data: Path, tmp_path: Path, settings: str, is_said: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.toml").write_text(settings)
    words = ["--split", "tiny", "--lang", "hi", "--settings", str(tmp_path / "own.toml")]
    assert main(["collect", "create", "street", *words]) == 0
    assert ("there is no consent text in hi: these pages show the English one" in capsys.readouterr().err) is is_said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["street", "--split", "nowhere", "--lang", "en"], "there is no split 'nowhere' in "),
        (["street", "--split", "tiny", "--lang", "xx"], "docs/how-to/languages.md says which files"),
        (["--split", "tiny", "--lang", "en"], "expected the collection's name"),
        (["A b", "--split", "tiny", "--lang", "en"], "the collection's name is 'A b'"),
        (["street", "--split", "tiny", "--lang", "en", "--episodes", "0"], "--episodes is 0; expected at least 1"),
        (["--review", "tiny", "--lang", "te"], "split 'tiny' has no texts in 'te' to review; there are en, hi"),
        (["street", "--split", "tiny", "--lang", "en", "--settings", "no.toml"], "no.toml: cannot be read"),
    ],
)
def test_wrong_collections_are_refused(
    data: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["collect", "create", *words]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("verifier = 2", "there is no setting 'verifier' of a collection; there are verifiers,"),
        ("keep_ndtw = 2", "keep_ndtw is 2: input should be less than or equal to 1"),
        ("currency = 'dollars'", "currency is 'dollars': string should match"),
        ("milestones = {0 = 5}", "a milestone is at less than 1 text"),
        ("smtp = {password = 'x'}", "there is no setting 'smtp.password'"),
        ("licence_address = 'javascript:1'", "licence_address is 'javascript:1': string should match"),
        ("consent_in = {hi = ''}", "consent_in.hi is ''"),
        ("verifiers = ", "is not TOML"),
    ],
)
def test_wrong_settings_are_named(
    data: Path, tmp_path: Path, line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.toml").write_text(line)
    words = ["collect", "create", "c", "--split", "tiny", "--lang", "en", "--settings", str(tmp_path / "own.toml")]
    assert main(words) == 1
    assert message in capsys.readouterr().err


def test_links_are_printed_once_and_work(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    assert main(["collect", "invite", "street", "--count", "2", "--note", "Pune"]) == 0
    links = capsys.readouterr().out.split()
    assert len(set(links)) == 2
    assert all(link.startswith("http://127.0.0.1:8080/en/collect/street/join?key=") for link in links)
    site = ["--site", "https://a.org/", "--page-lang", "hi", "--role", "host"]
    assert main(["collect", "invite", "street", *site]) == 0
    (host,) = capsys.readouterr().out.split()
    assert host.startswith("https://a.org/hi/collect/street/join?key=")
    with store(data) as opened:
        found = [opened.workers.by_link("street", link.partition("key=")[2]) for link in (*links, host)]
        assert [(one.role, one.note) for one in found if one] == [("worker", "Pune"), ("worker", "Pune"), ("host", "")]
        assert links[0].partition("key=")[2].encode() not in (data / "journal.db").read_bytes()
    assert main(["collect", "invite", "street", "--page-lang", "xx"]) == 1


def test_from_people_to_a_split(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    people = collect(data, ["0", "2", "4"])
    assert main(["collect", "status", "street"]) == 0
    out = capsys.readouterr().out
    assert "texts: discarded 1, kept 2" in out
    assert "tasks: verify submitted 9, write submitted 3" in out
    assert "owed: 5.00 USD" in out  # 3 * 1.00 + 9 * 0.20 + 2 * 0.10
    assert main(["collect", "export", "street"]) == 0
    folder = split_folder(data, "street")
    split = read_split(folder)
    assert sorted(split.episodes) == ["0", "2"]
    assert split.languages == {"en": 2}
    assert split.episodes["0"].instruction("en", 1, "navigation") == TEXTS[0][0]
    assert split.episodes["0"].turns == tiny.episode("0").turns
    provenance = json.loads((folder / "collection.json").read_text())
    assert (provenance["licence"], provenance["data_hash"]) == ("CC0-1.0", split.data_hash)
    assert [one["author"] for one in provenance["texts"]] == people[:2]
    assert {len(one["verifications"]) for one in provenance["texts"]} == {3}
    language, release = read_release(folder / "street.release.json", "en")
    assert [one.instructions[language] for one in release] == [split.episodes[key].instructions["en"] for key in "02"]
    assert [turn.actions for turn in release[0].turns] == [turn.actions for turn in split.episodes["0"].turns]
    capsys.readouterr()
    assert main(["stats", "--split", "street", "--lang", "en"]) == 0
    assert "paper" in capsys.readouterr().out


def test_agents_play_an_export_at_once(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also beside the running server of the same settings file, whose addresses are taken."""
    created(capsys)
    collect(data, ["0", "2"])
    assert main(["collect", "export", "street"]) == 0
    words = ["--agent", "agents.random_walk", "--split", "street", "--lang", "en", "--data", data]
    with socket.create_server(("127.0.0.1", 0)) as calls, socket.create_server(("127.0.0.1", 0)) as pages:
        settings = (tmp_path / "arramon.toml").read_text().replace("8080", str(pages.getsockname()[1]))
        (tmp_path / "arramon.toml").write_text(f'listen = "127.0.0.1:{calls.getsockname()[1]}"\n{settings}')
        played = forked.run(*words, "--output", tmp_path / "results", command=client)
    assert played.returncode == 0, played.stderr
    (result,) = (path for path in (tmp_path / "results").iterdir() if "receipt" not in path.name)
    episodes = json.loads(result.read_text())["episodes"]
    assert sorted(one["episode_id"] for one in episodes) == ["0", "2"]


def test_an_export_replaces_only_its_own_split(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    assert main(["collect", "export", "street"]) == 1
    assert "no text of collection 'street' was kept yet" in capsys.readouterr().err
    collect(data, ["0"])
    assert main(["collect", "export", "street", "--split", "tiny"]) == 1
    assert "there is a split 'tiny' already, and it is no export of this collection" in capsys.readouterr().err
    for _ in range(2):
        assert main(["collect", "export", "street"]) == 0


def test_the_ledger_as_csv(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    author, _, *verifiers = collect(data, ["0"])
    capsys.readouterr()
    assert main(["collect", "ledger", "street"]) == 0
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    found = sorted((row["worker"], row["kind"], row["amount"], row["currency"]) for row in rows)
    expected = [(author, "write", "1.00", "USD"), (author, "kept", "0.10", "USD")]
    assert found == sorted(expected + [(verifier, "verify", "0.20", "USD") for verifier in verifiers])


def test_forgetting_a_worker(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    author, *_ = collect(data, ["0", "2"])
    capsys.readouterr()
    assert main(["collect", "forget", "street", author, "--delete-texts"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "deleted: 0 runs, 1 texts; kept: 0 texts\n"
    assert "backups and exports made before still have this person's data" in captured.err
    assert main(["collect", "forget", "street", author]) == 1
    assert "was deleted already" in capsys.readouterr().err
    assert main(["collect", "export", "street"]) == 0
    assert list(read_split(split_folder(data, "street")).episodes) == ["2"]


def test_a_collection_that_reviews_generated_texts(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", "create", "--review", "tiny", "--lang", "hi", "--episodes", "3"]) == 0
    assert capsys.readouterr().out == "collection review-tiny-hi: review, hi, 3 episodes of tiny\n"
    with store(data) as opened:
        texts = opened.texts.all("review-tiny-hi")
    assert [(text.state, text.worker_id) for text in texts] == [("in_review", None)] * 3
    assert texts[0].instructions[0][0] == "धारीदार लाल मग तक चलें।"


def test_pausing_and_the_list_of_all(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", "status"]) == 1
    assert "there is no journal" in capsys.readouterr().err
    with store(data):
        assert main(["collect", "status"]) == 0
    assert "no collections; make one with" in capsys.readouterr().out
    created(capsys)
    for action, state in (("pause", "paused"), ("resume", "running"), ("close", "closed")):
        assert main(["collect", action, "street"]) == 0
        assert capsys.readouterr().out == f"collection street is {state}\n"
        assert main(["collect", "status", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["collections"][0]["state"] == state


def test_the_list_to_reconcile_has_no_formulas(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    with store(data) as opened:
        collection = opened.collections.get("street")
        worker = opened.workers.join(collection, "=1+1", ("write",))
        opened.visits.begin(worker.worker_id, "study", "@session")
        opened.workers.consent(worker, collection, keep_texts=False)
        task = opened.tasks.claim_write(collection, opened.workers.get(worker.worker_id), ["0"])
        assert task is not None
    assert main(["collect", "reconcile", "street", "--returned", "=1+1"]) == 0
    (row,) = csv.DictReader(capsys.readouterr().out.splitlines())
    assert (row["external_id"], row["session"], row["state"], row["owed"]) == ("'=1+1", "'@session", "returned", "0.00")
    with store(data) as opened:
        assert opened.tasks.get(task.task_id).state == "returned"


def test_what_a_thousand_episodes_cost(capsys: pytest.CaptureFixture[str], data: Path) -> None:
    assert main(["collect", "cost", "1000"]) == 0
    assert "1000 kept texts of 1111 written by 13 people, each followed by 3" in capsys.readouterr().out


def test_missing_words_of_the_pages_are_listed(capsys: pytest.CaptureFixture[str], data: Path, tmp_path: Path) -> None:
    assert main(["collect", "texts", "hi"]) == 0
    assert capsys.readouterr().out == ""
    assert main(["collect", "texts", "xx"]) == 1
