"""A worker from a crowd platform on a real server: from the study's address to the completion code."""

from contextlib import closing
from pathlib import Path

import pytest

from arramon_collecting.rules.screening import RIGHT_WRITE
from arramon_collecting.storage.store import Store
from arramon_server.cli import main
from arramon_server.runs.storage.database import Database
from tests.collecting.web.site import Browser
from tests.collecting.web.verify_site import DEVICE
from tests.collecting.web.writing.write_site import DONE_AT, EDITOR, SUBMISSION, TEXTS
from tests.web.play.page_client import PageServer

SETTINGS = """
min_seconds_write = 0
max_characters = 200
[platform]
key = "study-key"
[platform.studies.s1]
stages = ["write"]
code = "C0DE"
return_url = "https://platform.example/complete?cc={code}"
"""

HOME = "/en/collect/col/"


def test_from_the_studys_address_to_the_completion_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = tmp_path / "data"
    server = PageServer(data)
    (tmp_path / "settings.toml").write_text(SETTINGS)
    words = ["--split", "tiny", "--lang", "en", "--settings", str(tmp_path / "settings.toml"), "--data", str(data)]
    assert main(["collect", "create", "col", *words]) == 0
    browser = Browser(int(server.site.rpartition(":")[2]))
    join = f"{HOME}join?key=study-key&worker=p1&study=s1&session=x"
    for wrong in (join.replace("study-key", "no"), join.replace("s1", "s2")):
        assert browser.get(wrong).status in (403, 404)
    assert browser.get(join).location == HOME
    page = browser.get(HOME)
    (hashed,) = (part.partition('"')[0] for part in page.text.split('name="consent_hash" value="')[1:])
    browser.post(f"{HOME}consent", agree="yes", keep_texts="yes", consent_hash=hashed)
    assert "Follow instructions" not in browser.get(HOME).text  # the study is of the stage "write"
    assert browser.post(f"{HOME}take", stage="verify").status == 400
    assert browser.post(f"{HOME}take", stage="write").location == f"{HOME}device?stage=write"
    assert browser.send_json(f"{HOME}device", DEVICE).status == 200
    assert browser.post(f"{HOME}take", stage="write").location == f"{HOME}screening/write"
    task, _, passed = browser.post(f"{HOME}screening/write", **RIGHT_WRITE).location.partition("?")
    assert passed == "passed"
    assert browser.get(task).status == 200
    assert browser.send_json(f"{task}/open", {"editor": EDITOR}).status == 200
    draft = {"editor": EDITOR, "position": DONE_AT, "texts": list(TEXTS), "evidence": {}, "revision": 1}
    saved = browser.send_json(f"{task}/draft", draft)
    assert saved.status == 200, saved.text
    assert "Number of tasks: 1." in browser.get(HOME).text
    server.kill()
    server.start()
    assert "set-cookie" not in Browser(browser.port).get("/en/").headers  # public pages
    assert f'href="{task}"' in browser.get(HOME).text
    done = browser.send_json(f"{task}/submit", {**draft, "submission": SUBMISSION})
    assert done.status == 200, done.text
    assert browser.send_json(f"{task}/submit", {**draft, "submission": SUBMISSION}).status == 200
    page = browser.get(HOME)
    assert 'href="https://platform.example/complete?cc=C0DE"' in page.text
    assert '<td class="number">1.00 USD</td>' in page.text
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        store = Store(database)
        (worker,) = store.workers.all("col")
        assert store.ledger.total_of(worker.worker_id) == 100
        assert [one.state for one in store.visits.reconcile("col")] == ["complete"]
    assert server.stop() == 0
    assert "study-key" not in capsys.readouterr().err
