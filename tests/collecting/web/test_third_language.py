"""A collection in a language of data files alone: two write, three verify, a host reviews, an agent plays it."""

import asyncio
import json
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from textwrap import dedent

import pytest

from arramon_server.cli import main
from arramon_server.episodes.splits import read_split, split_folder
from tests import tiny
from tests.collecting.web.verify_site import DEVICE, browsers
from tests.collecting.web.writing.test_new_language import PAGE_WORDS, TEXTS
from tests.collecting.web.writing.write_site import Writer, WriteSite
from tests.collecting.writing.test_checks import QUALITY
from tests.lang.test_third_language import FILES

SETTINGS = {"min_seconds_write": 0, "min_seconds_verify": 0, "gold_share": 0.0}


def test_a_collection_from_its_data_files_to_a_played_split(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    languages, words, data = tmp_path / "languages", tmp_path / "words", tmp_path / "data"
    (languages / "eo").mkdir(parents=True)
    words.mkdir()
    for name in ("language", "lexicon", "relations"):
        (languages / "eo" / f"{name}.toml").write_text(dedent(FILES[name]))
    (languages / "eo" / "quality.toml").write_text(QUALITY)
    (words / "eo.toml").write_text(PAGE_WORDS)
    monkeypatch.setenv("ARRAMON_LANGUAGES", str(languages))
    monkeypatch.setenv("ARRAMON_COLLECT_TEXTS", str(words))
    site = WriteSite(data, "--steps", "20", environment={})
    with closing(site.database):
        first = site.writer("eo", **SETTINGS)
        name, second = first.collection.name, site.another_writer(first.collection)
        for writer in (first, second):
            writer.open()
            answer = writer.submit(TEXTS, submission=writer.worker.worker_id)
            assert answer.status == 200, answer.text
        for text in site.store.texts.all(name):  # the language has no word for one of the things, so a host looks first
            assert {failure["check"] for failure in text.failures} == {"no_target"}
            accept(site, first, text.text_id)
        verify(site, first)
        texts = site.store.texts.all(name)
        assert sorted(text.state for text in texts) == ["in_review", "kept"]
        (doubtful,) = (text for text in texts if text.state == "in_review")
        accept(site, first, doubtful.text_id)
        assert [text.state for text in site.store.texts.all(name)] == ["kept"] * 2
        assert site.store.ledger.total(name) == 2 * (100 + 10) + 6 * 20
    assert site.stop() == 0
    assert main(["collect", "export", name, "--data", str(data)]) == 0
    exported = read_split(split_folder(data, name))
    assert exported.languages == {"eo": 2}
    assert {episode.instruction("eo", 1, "navigation") for episode in exported.episodes.values()} == {TEXTS[0]}
    played = subprocess.run(
        [sys.executable, "-m", "arramon_client", "--agent", "agents.shortest_path", "--lang", "eo", "--split", name,
         "--data", str(data), "--output", str(tmp_path / "results"), "--quiet", "--json"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert json.loads(played.stdout)["run"]["language"] == "eo"


def verify(site: WriteSite, writer: Writer) -> None:
    """Let three people follow both texts; two of them flag one."""
    workers, collection = site.store.workers, writer.collection
    people = []
    for _ in range(3):
        person = site.worker(collection)
        workers.record_device(person.worker_id, DEVICE)
        now = site.store.clock().isoformat()
        workers.record_screening(person.worker_id, "verify", {"attempts": 0, "passed_at": now, "until": None})
        workers.record_placement(person.worker_id)
        people.append(workers.get(person.worker_id))

    async def play() -> None:
        async with browsers(site, *people) as opened:
            for number, browser in enumerate(opened):
                for _ in range(2):
                    path = browser.claim()
                    task = site.store.tasks.get(path.rpartition("/")[2])
                    messages = await browser.follow(path, tiny.ACTIONS)
                    assert messages[-1]["type"] == "run_ended"
                    flags = {"flag-1-navigation-unclear": "on"} if number < 2 and task.episode_id == "1" else {}
                    assert (await browser.post(f"{path}/hand-in", **flags))[0] == 303

    asyncio.run(play())


def accept(site: WriteSite, writer: Writer, text_id: str) -> None:
    """Let a host accept a text."""
    host, _ = site.store.workers.invite(writer.collection, role="host")

    async def press() -> None:
        async with browsers(site, host) as (browser,):
            assert TEXTS[0] in (await browser.get(f"/review/{text_id}"))[1]
            assert (await browser.post(f"/review/{text_id}/accept", version="1"))[0] == 303

    asyncio.run(press())
