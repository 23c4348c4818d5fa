"""The pages of a worker: joining, consent, tasks, money, leaving; and what a forged or repeated request does."""

import re
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

import pytest

from arramon_collecting.storage.people.records import FORGOTTEN, LEFT
from arramon_collecting.storage.work.records import OPEN, RETURNED
from tests.collecting.collecting import BADLY, TEXTS
from tests.collecting.storage.test_faults import full_disk
from tests.collecting.web.site import CONSENT, HOST_TOKEN, CollectingSite

HOME = "/en/collect/col/"


def test_a_link_signs_in_and_is_gone_from_the_address(site: CollectingSite) -> None:
    worker, key = site.field.store.workers.invite(site.field.collection)
    browser = site.browser()
    answer = browser.get(f"{HOME}join?key={key}")
    assert (answer.status, answer.location) == (303, HOME)
    for attribute in ("HttpOnly", "SameSite=Lax", "Path=/"):
        assert attribute in browser.set_cookie
    assert key not in "".join([*answer.headers.values(), answer.text])
    assert browser.get(HOME).status == 200
    assert site.field.store.workers.get(worker.worker_id).state == "invited"


def test_the_cookie_is_secure_behind_a_proxy(site: CollectingSite) -> None:
    _, key = site.field.store.workers.invite(site.field.collection)
    browser = site.browser()
    browser.get(f"{HOME}join?key={key}")
    assert "Secure" not in browser.set_cookie  # plain HTTP on this machine
    browser.get(f"{HOME}join?key={key}", **{"Host": "example.org", "X-Forwarded-Proto": "https"})
    assert "Secure" in browser.set_cookie


@pytest.mark.parametrize("key", ["", "forged", "x" * 5000, "\N{WAVING HAND SIGN}"])
def test_a_forged_link_is_refused(site: CollectingSite, key: str) -> None:
    browser = site.browser()
    answer = browser.get(f"{HOME}join?key={quote(key)}")
    assert (answer.status, browser.cookies) == (403, {})
    assert "this link is not valid" in answer.text


def test_without_a_sign_in_there_is_nothing(site: CollectingSite) -> None:
    browser = site.browser()
    assert browser.get(HOME).status == 401
    assert browser.post(f"{HOME}take", stage="write").status == 401
    browser.cookies["arramon_collect_col"] = "forged"
    assert browser.get(HOME).status == 401
    assert browser.get("/en/collect/other/").status == 404


def test_consent_is_recorded_with_its_hash_and_choice(site: CollectingSite) -> None:
    browser, worker_id = site.invited()
    page = browser.get(HOME)
    assert "You will write or follow short instructions" in page.text
    assert page.text.count("<p>You will write or follow") == 1
    assert browser.post(f"{HOME}take", stage="write").location == HOME  # not before
    hashed = site.field.collection.consent_hash
    assert browser.post(f"{HOME}consent", agree="yes", consent_hash=hashed).status == 400
    assert browser.post(f"{HOME}consent", **CONSENT, consent_hash="0").status == 400
    assert site.field.store.workers.get(worker_id).consented_at is None
    answer = browser.post(f"{HOME}consent", agree="yes", keep_texts="no", consent_hash=hashed)
    assert (answer.status, answer.location) == (303, HOME)
    worker = site.field.store.workers.get(worker_id)
    assert (worker.state, worker.keep_texts, worker.consent_hash) == ("active", False, hashed)
    assert worker.consented_at == site.field.clock.now


OWN = {"consent": "Mine.", "consent_in": {"hi": "मेरा।"}, "licence": "CC-BY-SA-4.0"}


@pytest.mark.parametrize(
    ("settings", "language", "shown", "text"),
    [
        ({}, "hi", "hi", "एक पहचान कोड के साथ रखे जाते हैं"),
        (OWN, "hi", "hi", "<p>मेरा।</p>"),
        (OWN, "en", "en", "<p>Mine.</p>"),
        ({"consent": "Mine."}, "hi", "en", "<p>Mine.</p>"),
    ],
)
def test_consent_is_in_the_language_of_the_page(
    tmp_path: Path, settings: dict[str, object], language: str, shown: str, text: str
) -> None:
    with closing(CollectingSite(tmp_path, **settings)) as site:
        browser, worker_id = site.invited()
        home = HOME.replace("/en/", f"/{language}/")
        page = browser.get(home).text
        assert text in page
        assert f'class="collect-consent" lang="{shown}"' in page
        assert f"deed.{language}" in page
        chosen = site.field.collection.settings
        hashes = {code: chosen.consent_shown(code).hash_with(chosen.licence) for code in ("en", "hi")}
        if shown != "en":
            assert browser.post(f"{home}consent", **CONSENT, consent_hash=hashes["en"]).status == 400
        assert browser.post(f"{home}consent", **CONSENT, consent_hash=hashes[language]).status == 303
        assert site.field.store.workers.get(worker_id).consent_hash == hashes[shown]


def test_what_is_missing_comes_before_the_first_task(site: CollectingSite) -> None:
    browser, worker_id = site.invited()
    browser.get(HOME)
    browser.post(f"{HOME}consent", **CONSENT, consent_hash=site.field.collection.consent_hash)
    browser.get(HOME)
    workers = site.field.store.workers

    def takes(stage: str) -> str:
        return browser.post(f"{HOME}take", stage=stage).location.removeprefix(HOME)

    assert takes("write") == "device?stage=write"
    workers.record_device(worker_id, {"problems": ["too_slow"]})
    assert takes("write") == "device?stage=write"
    workers.record_device(worker_id, {"problems": []})
    assert (takes("write"), takes("verify")) == ("screening/write", "screening/verify")
    workers.record_screening(worker_id, "write", {"attempts": 2, "passed_at": None})
    assert takes("write") == "screening/write"
    workers.record_screening(worker_id, "verify", {"passed_at": "2026-11-01T12:00:00+00:00"})
    assert takes("verify") == "placement"
    workers.record_screening(worker_id, "write", {"passed_at": "2026-11-01T12:00:00+00:00"})
    assert re.fullmatch(r"write/[0-9a-f]{32}", takes("write"))


def test_pay_and_notices_are_said(site: CollectingSite) -> None:
    browser, _ = site.consented()
    page = browser.get(HOME).text
    assert "pays 1.00 USD" in page
    assert "pays 0.20 USD" in page
    assert "0.10 USD for each set that others could follow" in page
    assert "A bonus of 0.90 USD when 20 of your sets" in page
    assert "were sent. Thank you!" in browser.get(f"{HOME}?notice=sent").text
    assert "You passed the test." in browser.get(f"{HOME}?notice=passed").text


def test_what_others_ticked_stands_at_the_set_that_was_discarded(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    field = site.field
    field.write(field.store.workers.get(worker_id))
    for flags in (("1-navigation-unclear",), ("1-navigation-unclear", "2-assembly-wrong"), ()):
        field.verify(field.worker(), BADLY, flags)
    page = browser.get(HOME).text
    assert "that were not taken, as others did not find the way or a place</dt><dd>1</dd>" in page
    assert "Not taken into the collection: others did not find the way or a place." in page
    assert "<p>Some who followed it did not find this:</p>\n<ul><li>Object 1: the way</li></ul>" in page
    assert "<li>Object 1: the way: unclear</li><li>Object 2: the place: wrong</li>" in page


def test_that_nothing_waits_is_said_before_the_tests(site: CollectingSite) -> None:
    browser, _ = site.consented()
    browser.get(HOME)
    answer = browser.post(f"{HOME}take", stage="verify")
    assert answer.location == f"{HOME}?notice=nothing_verify"
    assert "nothing for you under “Follow instructions”" in browser.get(answer.location).text


def test_two_tabs_get_the_same_task(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    browser.get(HOME)
    first, second = (browser.post(f"{HOME}take", stage="write").location for _ in range(2))
    assert first == second
    assert len(site.field.store.tasks.all_of(worker_id)) == 1
    assert browser.post(f"{HOME}take", stage="verify").status == 409


def test_a_task_is_given_back_and_goes_to_another(site: CollectingSite) -> None:
    (ann, ann_id), (bob, bob_id) = site.consented(), site.consented()
    for browser in (ann, bob):
        browser.get(HOME)
    ann.post(f"{HOME}take", stage="write")
    (task,) = site.field.store.tasks.all_of(ann_id)
    assert bob.post(f"{HOME}return", task=task.task_id).status == 404  # not Bob's
    assert site.field.store.tasks.get(task.task_id).state == OPEN
    assert ann.post(f"{HOME}return", task=task.task_id).location == f"{HOME}?notice=returned"
    assert ann.post(f"{HOME}return", task=task.task_id).status == 409
    assert site.field.store.tasks.get(task.task_id).state == RETURNED
    bob.post(f"{HOME}take", stage="write")
    ann.post(f"{HOME}take", stage="write")
    assert site.field.store.tasks.open_of(bob_id).episode_id == task.episode_id  # type: ignore[union-attr]
    assert site.field.store.tasks.open_of(ann_id).episode_id != task.episode_id  # type: ignore[union-attr]


def test_a_request_without_the_pages_value_changes_nothing(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    browser.get(HOME)
    good, browser.csrf = browser.csrf, "forged"
    for name in ("take", "return", "leave", "forget", "contact", "consent"):
        assert browser.post(f"{HOME}{name}", stage="write", sure="yes").status == 403
    browser.csrf = good
    browser.origin = "https://evil.example"
    assert browser.post(f"{HOME}leave").status == 403
    assert site.field.store.workers.get(worker_id).state == "active"
    assert site.field.store.tasks.all_of(worker_id) == []


def test_the_cookie_is_rotated_and_open_pages_go_on(site: CollectingSite) -> None:
    browser, _ = site.consented()
    browser.get(HOME)
    old = dict(browser.cookies)
    site.field.clock.advance(hours=2)
    assert browser.get(HOME).status == 200
    assert browser.cookies != old
    other = site.browser()
    other.cookies, other.csrf = old, browser.csrf
    assert other.get(HOME).status == 200  # for requests under way
    site.field.clock.advance(minutes=3)
    assert other.get(HOME).status == 401
    assert browser.post(f"{HOME}take", stage="write").status == 303
    site.field.clock.advance(days=31)
    assert browser.get(HOME).status == 401


def test_a_worker_sees_nothing_of_others(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    other, _ = site.consented(note="the other's note")
    site.field.write(site.field.store.workers.get(worker_id))
    browser.get(HOME)
    mine, others = browser.get(HOME).text, other.get(HOME).text
    owed = '<td class="number">1.00 USD</td>'
    assert owed in mine
    assert owed not in others
    assert worker_id not in others
    assert "the other&#39;s note" not in others


def test_a_text_that_was_sent_back_is_shown_with_its_reason_and_mended(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    field = site.field
    text = field.write(field.store.workers.get(worker_id)).text
    assert text is not None
    host = field.worker(role="host")
    field.store.reviews.send_back(field.collection, text.text_id, 1, host, "Say <b>which</b> bank.")
    page = browser.get(HOME).text
    assert "Say &lt;b&gt;which&lt;/b&gt; bank." in page
    task = field.store.tasks.get(browser.post(f"{HOME}take", stage="write", text=text.text_id).location[-32:])
    assert (task.text_id, task.episode_id) == (text.text_id, text.episode_id)
    mended = field.store.submissions.submit_text(field.collection, task, "again", TEXTS).text
    assert mended is not None
    assert (mended.state, mended.version, mended.text_id) == ("in_review", 2, text.text_id)
    assert mended.history[0]["version"] == 1


def test_authors_read_why_a_text_was_rejected_and_what_they_sent(site: CollectingSite) -> None:
    browser, worker_id = site.consented()
    store, collection = site.field.store, site.field.collection
    text = site.field.write(store.workers.get(worker_id)).text
    assert text is not None
    page = browser.get(HOME).text
    assert TEXTS[0][0] in page
    assert "Instructions that were not accepted" not in page
    store.reviews.reject(collection, text.text_id, 1, site.field.worker(role="host"), "no <b>such</b> bench")
    page = browser.get(HOME).text
    assert "Instructions that were not accepted" in page
    assert "no &lt;b&gt;such&lt;/b&gt; bench" in page
    other, _ = site.consented()
    assert TEXTS[0][0] not in other.get(HOME).text


def test_leaving_and_coming_back_by_the_link(site: CollectingSite) -> None:
    worker, key = site.field.store.workers.invite(site.field.collection)
    browser = site.browser()
    browser.get(f"{HOME}join?key={key}")
    browser.get(HOME)
    browser.post(f"{HOME}consent", **CONSENT, consent_hash=site.field.collection.consent_hash)
    site.ready(worker.worker_id)
    browser.post(f"{HOME}take", stage="write")
    assert "You have left" in browser.post(f"{HOME}leave").text
    assert site.field.store.workers.get(worker.worker_id).state == LEFT
    assert [task.state for task in site.field.store.tasks.all_of(worker.worker_id)] == [RETURNED]
    assert browser.get(HOME).status == 401
    browser.get(f"{HOME}join?key={key}")
    browser.get(HOME)
    assert browser.post(f"{HOME}take", stage="write").location.startswith(f"{HOME}write/")


def test_deleting_ones_data(site: CollectingSite) -> None:
    worker, key = site.field.store.workers.invite(site.field.collection, note="Ann of Pune")
    browser = site.browser()
    browser.get(f"{HOME}join?key={key}")
    browser.get(HOME)
    hashed = site.field.collection.consent_hash
    browser.post(f"{HOME}consent", agree="yes", keep_texts="no", consent_hash=hashed)
    site.field.write(site.field.store.workers.get(worker.worker_id))
    assert "This cannot be undone" in browser.get(f"{HOME}forget").text
    assert browser.post(f"{HOME}forget").status == 400
    assert "Your data was deleted" in browser.post(f"{HOME}forget", sure="yes").text
    assert browser.get(HOME).status == 401
    assert browser.get(f"{HOME}join?key={key}").status == 403
    assert site.field.store.workers.get(worker.worker_id).state == FORGOTTEN


def test_hosts_sign_in_with_a_token(site: CollectingSite) -> None:
    browser = site.browser()
    browser.origin = f"http://127.0.0.1:{site.site.port}"
    assert browser.get(f"{HOME}host").status == 200
    assert browser.post(f"{HOME}host", token="wrong").status == 401
    assert browser.post(f"{HOME}host", token="token-of-a-participant").status == 403
    browser.origin, good = "https://evil.example", browser.origin
    assert browser.post(f"{HOME}host", token=HOST_TOKEN).status == 403
    browser.origin = good
    assert browser.post(f"{HOME}host", token=HOST_TOKEN).location == f"{HOME}review"
    assert browser.get(HOME).location == f"{HOME}review"
    assert [worker.role for worker in site.field.store.workers.all("col")] == ["host"]


def test_links_cannot_be_tried_without_end(site: CollectingSite) -> None:
    browser = site.browser()
    statuses = [browser.get(f"{HOME}join?key={number}").status for number in range(32)]
    assert statuses == [403] * 30 + [429] * 2
    _, key = site.field.store.workers.invite(site.field.collection)
    assert browser.get(f"{HOME}join?key={key}").status == 303  # behind a proxy all have the same address


@pytest.mark.parametrize("language", ["en", "hi"])
def test_every_page_is_rendered_in_every_language(site: CollectingSite, language: str) -> None:
    browser, _ = site.consented()
    home = f"/{language}/collect/col/"
    for address in (home, f"{home}forget", f"{home}host"):
        answer = browser.get(address)
        assert answer.status == 200
        assert f'<html lang="{language}"' in answer.text
        assert answer.headers["cache-control"] == "no-store"
    assert browser.get(f"{home}join?key=no").status == 403


def test_a_full_disk_is_said_in_plain_words(site: CollectingSite) -> None:
    """Joining writes a row of its own, so that the file has to grow at some time."""
    _, key = site.field.store.workers.invite(site.field.collection)
    with full_disk(site.field.database):
        answers = [site.browser().get(f"{HOME}join?key={key}") for _ in range(25)]
    assert answers[-1].status == 503
    assert "The server cannot save anything at present" in answers[-1].text
    assert answers[-1].headers["retry-after"] == "5"
    assert site.browser().get(f"{HOME}join?key={key}").status == 303


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (b"x" * 400_000, "the request has more than 327680 bytes"),
        ("csrf=\N{WAVING HAND SIGN}".encode(), "the form is malformed"),
        (b"&".join(b"a=%d" % number for number in range(200)), "the form is malformed"),
        (b"csrf=%00%ff", "does not come from a page"),
    ],
)
def test_bodies_that_no_page_sends_are_refused(site: CollectingSite, body: bytes, message: str) -> None:
    browser, worker_id = site.consented()
    answer = browser.send(f"{HOME}take", body)
    assert answer.status in (400, 403)
    assert message in answer.text
    assert site.field.store.tasks.all_of(worker_id) == []


@pytest.mark.parametrize("email", ["a@b", "a@c.org\r\nBcc: x@y.org", "\u202ea@c.org", "a" * 400 + "@c.org"])
def test_wrong_addresses_are_refused_before_anything_is_recorded(site: CollectingSite, email: str) -> None:
    browser, worker_id = site.invited()
    browser.get(HOME)
    hashed = site.field.collection.consent_hash
    answer = browser.post(f"{HOME}consent", **CONSENT, consent_hash=hashed, email=email)
    assert answer.status == 400
    assert "the mail address is" in answer.text
    assert site.field.store.workers.get(worker_id).consented_at is None
