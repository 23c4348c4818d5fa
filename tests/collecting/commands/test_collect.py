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

[collections.street-hi]
min_seconds_write = 0
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


def collect(data: Path, episodes: list[str], name: str = "street") -> list[str]:
    """Let two people write, and three verify; return the ids of the people."""
    with store(data) as opened:
        collection = opened.collections.get(name)
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
        (["street", "--split", "tiny", "--lang", "en", "--episodes", "7"], "7 episodes are wanted, but tiny has 6"),
        (["--review", "tiny", "--lang", "en", "--episodes", "7"], "7 episodes are wanted, but tiny has 6"),
        (["tiny", "--split", "tiny", "--lang", "en"], "there is a split 'tiny' already"),
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
        ("currency = 'dollars'", "currency is 'dollars', expected three capital letters, such as USD or INR"),
        ("currency = 'XYZ'", "currency is 'XYZ', expected a code of ISO 4217"),
        ("pay_write = 0.5", "pay_write is 0.5, expected a whole number of the currency's smallest unit"),
        ("milestones = {5 = 0.5}", "milestones.5 is 0.5: input should be a valid integer"),
        ("consent = {en = 'x'}", "consent is {'en': 'x'}, expected one text of at most 20000 characters"),
        ("consent_in = {xx = 'x'}", "consent_in has 'xx'; the pages are in en, hi"),
        ("page_languages = ['en', 'xx']", "page_languages has 'xx'; the pages are in en, hi"),
        ("gold_episodes = ['0', 'x']", "gold_episodes has 'x', which tiny does not have"),
        ("episodes = 7", "7 episodes are wanted, but tiny has 6"),
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
    capsys.readouterr()
    assert main(["collect", "invite", "street", "--page-lang", "xx"]) == 1
    assert "the pages have no words in 'xx'" in capsys.readouterr().err
    assert main(["collect", "close", "street"]) == 0
    assert main(["collect", "invite", "street"]) == 0
    assert "the collection is closed and gives out no tasks" in capsys.readouterr().err
    assert main(["collect", "invite", "stret"]) == 1
    assert "there is no collection 'stret'; there are street" in capsys.readouterr().err


def test_from_people_to_a_split(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    people = collect(data, ["0", "2", "4"])
    assert main(["collect", "status", "street"]) == 0
    out = capsys.readouterr().out
    assert "episodes: all 6, decided 3, free 4" in out  # a discarded text's episode is free again
    assert "workers: active 5\n  hosts: none" in out
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
    assert f"the ledger has 1.10 USD for {author}" in captured.err
    assert "backups and exports made before still have this person's data" in captured.err
    assert main(["collect", "forget", "street", author]) == 1
    assert "was deleted already" in capsys.readouterr().err
    assert main(["collect", "export", "street"]) == 0
    assert list(read_split(split_folder(data, "street")).episodes) == ["2"]


def test_texts_can_be_deleted_after_the_other_data(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    created(capsys)
    author, *_ = collect(data, ["0", "2"])
    assert main(["collect", "forget", "street", author[:8]]) == 0
    captured = capsys.readouterr()
    assert captured.out == "deleted: 0 runs, 0 texts; kept: 1 texts\n"
    assert f"collect forget street {author} --delete-texts" in captured.err
    assert main(["collect", "export", "street"]) == 0
    provenance = json.loads((split_folder(data, "street") / "collection.json").read_text())
    assert [one["seconds"] for one in provenance["texts"] if one["author"] == author] == [None]
    assert main(["collect", "forget", "street", author]) == 1
    assert "was deleted already; the texts stay" in capsys.readouterr().err
    assert main(["collect", "forget", "street", author, "--delete-texts"]) == 0
    assert capsys.readouterr().out == "deleted: 0 runs, 1 texts; kept: 0 texts\n"
    assert main(["collect", "forget", "street", author, "--delete-texts"]) == 1
    assert "was deleted already; with all texts" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("worker", "message"),
    [
        ("zzzz", "there is no worker 'zzzz' in collection 'street'; `collect status street --workers` lists them"),
        ("abc", "the worker is 'abc', expected at least 4 characters of the pseudonym"),
        ("0" * 8, "2 workers begin with '00000000'"),
    ],
)
def test_a_worker_is_found_by_the_beginning_of_the_pseudonym(
    data: Path, worker: str, message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    created(capsys)
    ids = iter(("0" * 31 + "1", "0" * 31 + "2"))
    monkeypatch.setattr("arramon_collecting.storage.people.workers.new_id", lambda: next(ids))
    assert main(["collect", "invite", "street", "--count", "2"]) == 0
    assert main(["collect", "forget", "street", worker]) == 1
    assert message in capsys.readouterr().err


def test_create_says_which_settings_and_terms_it_took(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "arramon.toml"
    words = ["--split", "tiny", "--lang", "en"]
    assert main(["collect", "create", "street", *words]) == 0
    said = capsys.readouterr().err
    assert f"settings: [collections.street] of {file}\n" in said
    assert "consent text: en: the default one, which you should replace, hi: the default one" in said
    assert "payment: 1.00 USD for four texts, 0.20 USD for a verification" in said
    assert main(["collect", "create", "stret", *words]) == 0
    said = capsys.readouterr().err
    assert f"settings: the defaults, as {file} has no table [collections.stret]; it has [collections.street], " in said
    monkeypatch.delenv("ARRAMON_CONFIG")
    assert main(["collect", "create", "third", *words, "--data", str(data)]) == 0
    assert "the defaults, as no settings file is named by --config or $ARRAMON_CONFIG" in capsys.readouterr().err
    own = tmp_path / "own.toml"
    own.write_text("consent = 'Ours.'\ncurrency = 'INR'\n")
    assert main(["collect", "create", "fourth", *words, "--data", str(data), "--settings", str(own)]) == 0
    said = capsys.readouterr().err
    assert f"settings: {own}\nconsent text: en: your own, hi: missing\n" in said
    assert "the paper's dollars are paid as INR" in said
    assert main(["collect", "create", "fourth", *words, "--data", str(data)]) == 1
    said = capsys.readouterr().err
    assert "there is a collection 'fourth' already: write, en, split tiny, running. Its settings are fixed" in said


def test_a_collection_is_deleted_as_long_as_nobody_has_signed_in(
    data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    created(capsys)
    assert main(["collect", "invite", "street", "--note", "Pune"]) == 0
    assert main(["collect", "delete", "street"]) == 0
    assert b"Pune" not in (data / "journal.db").read_bytes()
    assert main(["collect", "status", "street"]) == 1
    assert "there is no collection 'street'; there are none yet" in capsys.readouterr().err
    assert main(["collect", "create", "--review", "tiny", "--lang", "hi"]) == 0
    assert main(["collect", "delete", "review-tiny-hi"]) == 0
    created_again = ["collect", "create", "street", "--split", "tiny", "--lang", "hi"]
    assert main(created_again) == 0
    with store(data) as opened:
        host, _ = opened.workers.invite(opened.collections.get("street"), role="host")
        opened.sign_ins.open(host.worker_id)
        assert opened.workers.get(host.worker_id).state == "active"
    assert main(["collect", "delete", "street"]) == 1
    assert "somebody has signed in to collection 'street'; close it" in capsys.readouterr().err


def test_collections_of_one_split_are_exported_as_one_with_several_languages(
    data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, language in (("street", "en"), ("street-hi", "hi"), ("again", "en")):
        assert main(["collect", "create", name, "--split", "tiny", "--lang", language]) == 0
    collect(data, ["0", "2"])
    collect(data, ["2", "1"], "street-hi")
    assert main(["collect", "export", "street", "street-hi"]) == 1
    assert "expected the name of the split for several collections" in capsys.readouterr().err
    assert main(["collect", "export", "street", "again", "--split", "both"]) == 1
    assert "several collections are in 'en'; expected one for each language" in capsys.readouterr().err
    for _ in range(2):
        assert main(["collect", "export", "street", "street-hi", "--split", "both"]) == 0
    folder = split_folder(data, "both")
    split = read_split(folder)
    assert {key: sorted(episode.instructions) for key, episode in split.episodes.items()} == {
        "0": ["en"], "1": ["hi"], "2": ["en", "hi"],
    }  # fmt: skip
    provenance = json.loads((folder / "collection.json").read_text())
    assert [(one["collection"], one["language"], len(one["texts"])) for one in provenance["collections"]] == [
        ("street", "en", 2), ("street-hi", "hi", 2),
    ]  # fmt: skip
    assert provenance["data_hash"] == split.data_hash
    _, release = read_release(folder / "both.hi.release.json", "hi")
    assert len(release) == 2
    assert main(["collect", "export", "street", "--split", "both"]) == 1
    assert "it is no export of this collection" in capsys.readouterr().err


def test_a_collection_that_reviews_generated_texts(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", "create", "--review", "tiny", "--lang", "hi", "--episodes", "3"]) == 0
    assert capsys.readouterr().out == "collection review-tiny-hi: review, hi, 3 episodes of tiny\n"
    with store(data) as opened:
        texts = opened.texts.all("review-tiny-hi")
    assert [(text.state, text.worker_id) for text in texts] == [("in_review", None)] * 3
    assert texts[0].instructions[0][0] == "धारीदार लाल मग तक चलें।"


def test_pausing_and_the_list_of_all(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["collect", "status"]) == 0
    assert "no collections yet; make one with" in capsys.readouterr().out
    assert main(["collect", "status", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"collections": [], "workers": []}
    with store(data):
        assert main(["collect", "status"]) == 0
    assert "no collections yet; make one with" in capsys.readouterr().out
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
