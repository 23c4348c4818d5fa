"""The write page's requests on a real server: views, drafts by revision, submissions that count once, bad input."""

import resource
import time
from contextlib import closing
from pathlib import Path

import pytest

from arramon_collecting.storage.texts.records import IN_REVIEW, SENT_BACK, VERIFYING
from arramon_collecting.storage.work.records import EXPIRED, SUBMITTED
from arramon_server.runs.storage.collection_tables import tasks, texts
from tests.collecting.web.writing.write_site import DONE_AT, EDITOR, OTHER_EDITOR, TEXTS, Writer, WriteSite

START_AT = "0.0.0.2.0.0"


@pytest.fixture
def writer(site: WriteSite) -> Writer:
    return site.writer()


@pytest.mark.parametrize("language", ["en", "hi"])
def test_the_page_has_its_words_and_runs_nothing_inline(site: WriteSite, language: str) -> None:
    writer = site.writer(language)
    answer = writer.request("GET", writer.page.replace("/en/", f"/{language}/"))
    assert answer.status == 200
    assert {"en": "Write instructions", "hi": "निर्देश लिखें"}[language] in answer.text
    assert "unsafe" not in answer.headers["Content-Security-Policy"]
    assert answer.headers["Cache-Control"] == "no-store"
    assert f'<textarea id="text" lang="{language}"' in answer.text


def test_examples_are_in_the_language_that_is_written(site: WriteSite) -> None:
    answer = site.writer("hi").get()
    assert "How to write good instructions" in answer.text
    assert "Write in this language: हिन्दी." in answer.text
    assert '<p class="example" lang="hi">बिंदीदार भूरे टीवी को' in answer.text


def test_nobody_else_sees_a_task(site: WriteSite, writer: Writer) -> None:
    other = site.writer()
    other.page = writer.page
    assert other.get().status == 401, "a cookie is for one collection"
    colleague = Writer(site, writer.collection, site.worker(writer.collection), writer.task)
    for answer in (
        colleague.get(),
        colleague.get("/view", at=START_AT),
        colleague.get("/draft"),
        colleague.post("/open", {"editor": EDITOR}),
        colleague.submit(),
    ):
        assert answer.status == 404


@pytest.mark.parametrize(
    ("query", "position", "outcome", "progress", "bearing"),
    [
        ({"at": START_AT}, START_AT, "", "0.000", "0"),
        ({"at": START_AT, "move": "forward"}, "0.1.0.2.0.0", "moved", "0.500", "0"),
        ({"at": START_AT, "move": "left"}, "0.0.11.2.0.0", "turned", "0.000", "30"),
        ({"at": "0.2.0.2.0.0", "move": "act"}, "1.0.0.2.0.1", "picked_up", "0.000", "0"),
        ({"at": "1.0.0.2.2.1"}, "1.0.0.2.2.1", "", "0.000", ""),
        ({"at": DONE_AT, "part": "2"}, "2.0.0.2.0.4", "", "0.000", "90"),
    ],
)
def test_views(writer: Writer, query: dict[str, str], position: str, outcome: str, progress: str, bearing: str) -> None:
    answer = writer.get("/view", **query)
    assert (answer.status, answer.headers["Content-Type"]) == (200, "image/jpeg")
    assert answer.body.startswith(b"\xff\xd8")
    facts = [answer.headers[f"Arramon-{name}"] for name in ("Position", "Outcome", "Progress", "Bearing")]
    assert facts == [position, outcome, progress, bearing]


@pytest.mark.parametrize(
    ("query", "problem"),
    [
        ({}, "position ''"),
        ({"at": "9" * 500}, "500 characters"),
        ({"at": START_AT, "move": "fly"}, "move 'fly', expected one of forward, back, left, right, act"),
        ({"at": START_AT, "part": "3"}, "part 3 has not been reached"),
        ({"at": START_AT, "part": "-1"}, "part '-1', expected a number"),
    ],
)
def test_bad_views(writer: Writer, query: dict[str, str], problem: str) -> None:
    answer = writer.get("/view", **query)
    assert answer.status == 400
    assert problem in answer.json["error"]


def test_drafts_are_saved_by_revision_and_an_older_one_gets_the_newer_one(writer: Writer) -> None:
    first = writer.open()
    assert (first["before"], first["revision"], first["texts"]) == (0, 1, [""] * 4)
    saved = writer.post("/draft", writer.written(revision=1))
    assert (saved.status, saved.json["revision"]) == (200, 2)
    older = writer.post("/draft", writer.written(("other", "", "", ""), revision=1))
    assert older.status == 409
    assert older.json["newer"]["revision"] == 2
    assert older.json["newer"]["body"]["texts"] == list(TEXTS)
    assert writer.post("/draft", writer.written(revision=1)).json["revision"] == 2, "its answer was lost: nothing new"
    assert writer.get("/draft").json == {"revision": 2, "editor": EDITOR}


def test_a_second_window_takes_over(writer: Writer) -> None:
    writer.open()
    writer.post("/draft", writer.written(revision=1))
    second = writer.open(OTHER_EDITOR)
    assert (second["revision"], second["texts"], second["editor"]) == (3, list(TEXTS), OTHER_EDITOR)
    late = writer.post("/draft", writer.written(("late", "", "", ""), revision=2))
    assert (late.status, late.json["newer"]["body"]["editor"]) == (409, OTHER_EDITOR)
    assert writer.submit().status == 409, "the first window cannot submit what the second one has changed"
    assert writer.submit(editor=OTHER_EDITOR).status == 200


def test_drafts_survive_a_killed_server(tmp_path: Path) -> None:
    site = WriteSite(tmp_path)
    with closing(site.database):
        writer = site.writer()
        writer.open()
        assert writer.post("/draft", writer.written(revision=1)).status == 200
        site.kill()
        site.start()
        assert writer.open(OTHER_EDITOR)["texts"] == list(TEXTS)
    assert site.stop() == 0


def test_a_full_disk_loses_nothing(tmp_path: Path) -> None:
    site = WriteSite(tmp_path)
    with closing(site.database):
        writer = site.writer()
        writer.open()
        resource.prlimit(site.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        refused = [writer.post("/draft", writer.written(revision=1)), writer.submit()]
        assert [answer.status for answer in refused] == [503, 503]
        resource.prlimit(site.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
        for _ in range(20):  # As the page does: the database may need a moment for what the full disk left behind.
            saved = writer.post("/draft", writer.written(revision=1))
            if saved.status != 503:
                break
            time.sleep(0.5)
        assert saved.json["revision"] == 2
        assert writer.submit().status == 200
        assert site.store.ledger.total_of(writer.worker.worker_id) == 100
    assert site.stop() == 0


def test_checks_come_with_each_save(writer: Writer) -> None:
    writer.open()
    cone = "Turn right, pass the orange cone, take the dotted blue tv"
    typed = ("\N{GRINNING FACE} Walk two steps to the mug", "", cone, "")
    findings = writer.post("/draft", writer.written(typed, revision=1)).json["findings"]
    street = {finding["check"]: finding for finding in findings[0]}
    assert street["picture"]["marks"] == [[0, 2]], "scripts count two for a character of four bytes"
    assert street["term"] == {
        "check": "term",
        "severity": "blocked",
        "message": "“steps” counts paces or turns. Say up to what to walk, or which way to turn, instead.",
        "marks": [[12, 17]],
    }
    assert [finding["check"] for finding in findings[1]] == [], "a text that is not begun has no faults yet"
    assert {finding["check"]: finding["severity"] for finding in findings[2]} == {"not_there": "hint"}


@pytest.mark.parametrize(
    ("text", "check"),
    [
        ("", "few_words"),
        ("Walk on and take the mug \N{GRINNING FACE} there.", "picture"),
        ("Walk on\u200b and pick up the striped red mug.", "invisible"),
        ("Walk on and pick up the \u202estriped red mug.", "invisible"),
        ("Walk on, press a key and pick up the mug.", "term"),
        ("Walk on and on past it all " * 20, "too_long"),
    ],
)
def test_what_blocks_is_not_submitted_and_said_clearly(site: WriteSite, writer: Writer, text: str, check: str) -> None:
    writer.open()
    answer = writer.submit((text, *TEXTS[1:]))
    assert answer.status == 422
    blocked = [finding for finding in answer.json["findings"][0] if finding["severity"] == "blocked"]
    assert check in [finding["check"] for finding in blocked]
    assert all(finding["message"] for finding in blocked)
    assert site.store.texts.all(writer.collection.name) == []
    assert site.store.tasks.get(writer.task.task_id).state == "open"


def test_a_submission_counts_once(site: WriteSite, writer: Writer) -> None:
    writer.open()
    typed = ("  Walk straight ahead to the\nbrick building and pick up the striped  red mug.", *TEXTS[1:])
    for _ in range(2):
        answer = writer.submit(typed, evidence={"pastes": 2})
        assert (answer.status, answer.json) == (200, {"next": f"/en/collect/{writer.collection.name}/?notice=sent"})
    (text,) = site.store.texts.all(writer.collection.name)
    assert (text.state, text.evidence) == (VERIFYING, {"pastes": 2})
    assert [failure["severity"] for failure in text.failures] == ["hint"]
    assert text.instructions == ((TEXTS[0], TEXTS[1]), (TEXTS[2], TEXTS[3]))
    assert site.store.ledger.total_of(writer.worker.worker_id) == 100
    assert writer.submit(submission="d" * 32).status == 409
    assert writer.post("/draft", writer.written(revision=1)).status == 409
    assert writer.get().status == 409


def test_what_is_suspicious_goes_to_review_and_hints_do_not(site: WriteSite) -> None:
    cone = "Walk past the orange cone on your left and pick up the striped red mug."
    line = "Walk along the blue line and pick up the striped red mug there."
    for text, check, state in ((cone, "not_there", VERIFYING), (line, "interface", IN_REVIEW)):
        writer = site.writer()
        writer.open()
        assert writer.submit((text, *TEXTS[1:])).status == 200
        (found,) = site.store.texts.all(writer.collection.name)
        (failure,) = [failure for failure in found.failures if (failure["turn"], failure["phase"]) == (1, "navigation")]
        assert (failure["check"], found.state) == (check, state)
        assert failure["message"]


def test_who_has_not_walked_to_the_end_cannot_submit(writer: Writer) -> None:
    writer.open()
    answer = writer.submit(position="2.0.0.2.0.3")
    assert answer.status == 400
    assert "walk to the end" in answer.json["error"]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"{", "JSON"),
        (b"[]", "no JSON object"),
        ({"revision": 1}, "texts is no list of 4 texts"),
        ({"texts": ["", "", "", 4]}, "texts is no list of 4 texts"),
        ({"texts": ["x" * 100_000, "", "", ""]}, "a text has 100000 characters; at most 10000 can be kept"),
        (b'{"texts": ["\\ud800", "", "", ""]}', "half"),
        ({"texts": [""] * 4, "position": "0.9.0.2.0.0", "editor": EDITOR, "revision": 1}, "beyond the end of the line"),
        ({"texts": [""] * 4, "position": START_AT, "editor": "me", "revision": 1}, "editor is 'me'"),
        ({"texts": [""] * 4, "position": START_AT, "editor": EDITOR, "revision": -1}, "revision is '-1'"),
        ({"texts": [""] * 4, "position": START_AT, "editor": EDITOR, "revision": 1, "evidence": {"pastes": 0.5}},
         "pastes is '0.5'"),
        (b" " * 400_000, "bytes"),
    ],
)  # fmt: skip
def test_bad_drafts(writer: Writer, content: object, problem: str) -> None:
    writer.open()
    answer = writer.post("/draft", content)
    assert answer.status == 400
    assert problem in answer.json["error"]


def test_forged_requests_change_nothing(site: WriteSite, writer: Writer) -> None:
    for headers in ({"X-CSRF-Token": ""}, {"X-CSRF-Token": "0" * 43}, {"Origin": "https://elsewhere.example"}):
        assert writer.post("/open", {"editor": EDITOR}, **headers).status == 403
    assert site.store.drafts.get(writer.task.task_id).revision == 0
    writer.cookie = "forged"
    assert writer.post("/open", {"editor": EDITOR}).status == 401


def test_tasks_that_expired_go_on_and_returned_ones_do_not(site: WriteSite, writer: Writer) -> None:
    writer.open()
    with site.database.write() as connection:
        mine = tasks.c.task_id == writer.task.task_id
        connection.execute(tasks.update().where(mine).values(state=EXPIRED))
    assert writer.post("/draft", writer.written(revision=1)).status == 200
    site.store.tasks.give_back(writer.task.task_id)
    answer = writer.post("/draft", writer.written(revision=2))
    assert (answer.status, "newer" in answer.json) == (409, False)


def test_a_text_that_was_sent_back_is_mended(site: WriteSite, writer: Writer) -> None:
    writer.open()
    writer.submit()
    (text,) = site.store.texts.all(writer.collection.name)
    with site.database.write() as connection:
        connection.execute(
            texts.update()
            .where(texts.c.text_id == text.text_id)
            .values(state=SENT_BACK, reason="Which <b>building</b>?")
        )
    task = site.store.tasks.claim_mend(writer.collection, writer.worker, text.text_id)
    again = Writer(site, writer.collection, writer.worker, task)
    assert "Which &lt;b&gt;building&lt;/b&gt;?" in again.get().text
    opened = again.open()
    assert (opened["texts"], opened["position"]) == (list(TEXTS), "0.0.0.2.0.4")
    assert again.submit(submission="e" * 32).status == 200
    assert site.store.tasks.get(task.task_id).state == SUBMITTED


def test_active_time_grows_with_every_save(site: WriteSite, writer: Writer) -> None:
    writer.open()
    before = site.store.tasks.get(writer.task.task_id).active_seconds
    writer.post("/draft", writer.written(revision=1))
    assert site.store.tasks.get(writer.task.task_id).active_seconds > before
