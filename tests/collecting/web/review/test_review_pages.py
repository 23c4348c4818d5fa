"""Hosts' pages on a real server: figures, a text with everything known, decisions, playback, workers, ledger."""

import asyncio
import csv
import io
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import tiny
from tests.collecting.web.verify_site import NAME, TEXTS, VerifySite, browsers, verify_site

FAILURE = {"turn": 1, "phase": "navigation", "check": "few_words", "severity": "suspicious", "message": "few <words>"}


@pytest.fixture
def site(tmp_path: Path) -> Iterator[VerifySite]:
    with verify_site(tmp_path) as site:
        yield site


def test_a_text_from_review_to_kept(site: VerifySite) -> None:
    author = site.worker()
    text = site.text(author, failures=[FAILURE], evidence={"pasted": "<b>40 characters</b>"})
    page = f"/review/{text.text_id}"

    async def play() -> None:
        async with browsers(site, site.host, *(site.worker() for _ in range(3))) as (host, *people):
            _, shown = await host.get("/review")
            assert text.text_id in shown
            _, shown = await host.get(page)
            assert "few &lt;words&gt;" in shown
            assert "&lt;b&gt;40 characters" in shown  # of strangers, escaped
            assert "goes to the verifiers" in shown
            assert (await host.post(f"{page}/accept", version="2"))[0] == 409
            assert (await host.post(f"{page}/accept", version="1")) == (
                303,
                f"/en/collect/{NAME}/review?decided=verifying",
            )
            for person in people:
                path = person.claim()
                await person.follow(path)
                await person.post(f"{path}/hand-in", **{"flag-2-assembly-wrong": "on"})
            assert site.store.texts.get(text.text_id).state == "in_review"  # three flagged it
            _, shown = await host.get(page)
            assert shown.count('class="way way-') == 6
            assert "wrong × 3" in shown
            assert "nDTW between their ways 1.000, same tile 100%" in shown
            assert "It is then kept" in shown
            verification = site.store.verifications.of_text(text.text_id)[0]
            for walk in (verification.task_id, "described"):
                status, shown = await host.get(f"{page}/walks/{walk}")
                assert (status, 'id="watch"' in shown) == (200, True)
                status, moments = await host.get(f"{page}/walks/{walk}/moments.json")
                assert (status, moments.count('"step":')) == (200, len(tiny.ACTIONS) + 1)
                async with host.session.get(
                    f"{site.pages}{page}/walks/{walk}/frames/3.jpg?size=224", headers=host.headers
                ) as answer:
                    assert (answer.status, (await answer.read())[:2]) == (200, b"\xff\xd8")
                assert (await host.get(f"{page}/walks/{walk}/frames/99.jpg"))[0] == 404
            assert (await host.post(f"{page}/accept", version="1"))[0] == 303
            _, shown = await host.get("/review?state=kept&decided=kept")
            assert "The text is now: kept." in shown
            assert "1.80 USD" not in shown
            _, shown = await host.get("/workers")
            assert shown.count('id="worker-') == 4
            _, shown = await host.get("/ledger")
            assert "1.70 USD" in shown
            _, file = await host.get("/ledger.csv")
            rows = list(csv.DictReader(io.StringIO(file)))
            assert sorted(row["amount"] for row in rows) == ["0.10", "0.20", "0.20", "0.20", "1.00"]

    asyncio.run(play())
    assert site.store.texts.get(text.text_id).state == "kept"


def test_a_text_is_sent_back_and_rejected_with_a_reason(site: VerifySite) -> None:
    author = site.worker()
    sent, rejected = (site.text(author, episode, failures=[FAILURE]) for episode in ("1", "2"))

    async def play() -> None:
        async with browsers(site, site.host) as (host,):
            page = f"/review/{sent.text_id}"
            status, shown = await host.post(f"{page}/send_back", version="1", reason=" ")
            assert (status, "Please write the reason, or tick a box." in shown) == (400, True)
            assert 'name="reason" rows="3" maxlength="1900" required' in shown
            assert "0 of 6 episodes" in (await host.get("/review"))[1]
            fields = {"version": "1", "reason": "which  bench?", "flag-unclear": "unclear"}
            status, address = await host.post(f"{page}/send_back", **fields)
            assert (status, address) == (303, f"/en/collect/{NAME}/review/{rejected.text_id}?decided=sent_back")
            await host.post(f"/review/{rejected.text_id}/reject", version="1", reason="no Hindi")
            assert "0 of 6 episodes" in (await host.get("/review"))[1]  # the rejected one is free again
            assert (await host.post(f"/review/{rejected.text_id}/mend", version="1"))[0] == 409

    asyncio.run(play())
    texts = site.store.texts
    assert [(texts.get(one.text_id).state, texts.get(one.text_id).reason) for one in (sent, rejected)] == [
        ("sent_back", "unclear: which bench?"), ("rejected", "no Hindi"),
    ]  # fmt: skip


def test_generated_texts_are_accepted_mended_or_flagged(site: VerifySite) -> None:
    generated = [("1", TEXTS), ("2", TEXTS), ("4", TEXTS)]
    settings = site.collection.settings
    reviewed = site.store.collections.create("generated", "review", "hi", "tiny", settings, generated)
    host, _ = site.store.workers.invite(reviewed, role="host")
    accepted, mended, flagged = site.store.texts.all("generated")

    async def play() -> None:
        async with browsers(site, host) as (person,):
            assert "0 of 3 episodes" in (await person.get("/review"))[1]
            assert "textarea" in (await person.get(f"/review/{mended.text_id}"))[1]
            assert (await person.post(f"/review/{accepted.text_id}/accept", version="1"))[0] == 303
            said = {"1-navigation": "दो क़दम  चलें।", "1-assembly": TEXTS[0][1], "2-navigation": TEXTS[1][0]}
            mend = f"/review/{mended.text_id}/mend"
            assert (await person.post(mend, version="1", **said))[0] == 400  # one is missing
            assert (await person.post(mend, version="1", **said, **{"2-assembly": TEXTS[1][1]}))[0] == 303
            fields = {"flag-ungrammatical": "ungrammatical", "reason": ""}
            assert (await person.post(f"/review/{flagged.text_id}/reject", version="1", **fields))[0] == 303
            assert "3 of 3 episodes" in (await person.get("/review"))[1]

    asyncio.run(play())
    found = [site.store.texts.get(one.text_id) for one in (accepted, mended, flagged)]
    assert [one.state for one in found] == ["kept", "kept", "rejected"]
    assert [one.version for one in found] == [1, 2, 1]
    assert found[1].instructions[0][0] == "दो क़दम चलें।"
    assert found[1].history[0]["instructions"] == [list(pair) for pair in TEXTS]
    assert found[2].reason == "ungrammatical"


FINDINGS = [
    FAILURE | {"check": "other_cell", "phase": "assembly", "severity": "hint", "words": [], "expected": ""},
    FAILURE | {"check": "not_there", "severity": "hint", "words": [], "expected": "bench"},
]


def test_a_host_sees_the_room_by_name_and_checks_in_words_for_hosts(site: VerifySite) -> None:
    text = site.text(site.worker(), failures=FINDINGS)

    async def play() -> None:
        async with browsers(site, site.host) as (host,):
            _, shown = await host.get(f"/review/{text.text_id}")
            assert "would place the object on another tile. It may have misread the text" in shown
            assert "found nothing of this kind along the way: bench" in shown
            assert shown.count('class="yellow"') == 2
            room = tiny.episode("1")
            types = [decoy.type for decoy in room.decoys]
            for type_ in (*types, room.turns[0].target.type):  # what is there in turn 2
                words = (type_.pattern, type_.colour, type_.kind.replace("tv", "TV"))
                assert " ".join(words) in shown
                assert all(f">{word}</text>" in shown for word in words)

    asyncio.run(play())


def test_what_is_wrong_with_a_mended_text_is_said_in_the_page_s_language(site: VerifySite) -> None:
    reviewed = site.store.collections.create("gen", "review", "hi", "tiny", site.collection.settings, [("1", TEXTS)])
    host, _ = site.store.workers.invite(reviewed, role="host")
    (text,) = site.store.texts.all("gen")
    said = {"1-navigation": TEXTS[0][0], "1-assembly": TEXTS[0][1], "2-navigation": TEXTS[1][0]}

    async def play() -> None:
        async with browsers(site, host) as (person,):
            _, shown = await person.get(f"/review/{text.text_id}")
            assert "Reason, which is kept with the text" in shown
            assert "Send back" not in shown
            assert "Nobody has verified this text yet" not in shown
            person.pages = person.pages.replace("/en/", "/hi/")
            status, shown = await person.post(
                f"/review/{text.text_id}/mend", version="1", **said, **{"2-assembly": "मग को 😀 रखें।"}
            )
            assert (status, "इमोजी और चित्र नहीं लिख सकते: 😀" in shown) == (400, True)
            assert ">मग को 😀 रखें।</textarea>" in shown  # what was typed is still there
            assert "Krippendorff" not in (await person.get("/review"))[1]

    asyncio.run(play())
    assert site.store.texts.get(text.text_id).version == 1


def test_a_worker_s_page_leads_to_texts_and_walks(site: VerifySite) -> None:
    author, other = site.worker(), site.worker()
    text = site.text(author)
    noted, _ = site.store.workers.invite(site.collection, note="Ann of Pune")
    site.store.workers.invite(site.collection, role="host", note="Ben of Delhi")

    async def play() -> None:
        async with browsers(site, site.host, other) as (host, person):
            path = person.claim()
            await person.follow(path)
            await person.post(f"{path}/hand-in")
            _, shown = await host.get("/workers")
            assert all(note in shown for note in ("Ann of Pune", "Ben of Delhi"))
            for one in (author, other, noted):
                assert f'/workers/{one.worker_id}"' in shown
            assert f'/review/{text.text_id}"' in (await host.get(f"/workers/{author.worker_id}"))[1]
            _, shown = await host.get(f"/workers/{other.worker_id}")
            (walk,) = site.store.verifications.of_text(text.text_id)
            assert f'/review/{text.text_id}/walks/{walk.task_id}"' in shown
            assert "Ann of Pune" in (await host.get(f"/workers/{noted.worker_id}"))[1]
            assert (await person.get(f"/workers/{other.worker_id}"))[0] == 404
            # The pages go on without the walk of somebody whose data was deleted.
            site.store.removal.forget(site.collection, other.worker_id)
            for page in ("/review", f"/review/{text.text_id}", "/workers", f"/workers/{other.worker_id}"):
                status, shown = await host.get(page)
                assert (status, f"walks/{walk.task_id}" in shown) == (200, False)
            assert "0 min 0 s" not in shown

    asyncio.run(play())


def test_workers_are_paused_blocked_and_readmitted(site: VerifySite) -> None:
    worker = site.worker()

    async def play() -> None:
        async with browsers(site, site.host, worker) as (host, person):
            change = f"/workers/{worker.worker_id}/state"
            assert (await host.post(change, state="paused")) == (303, f"/en/collect/{NAME}/workers?changed=paused")
            assert (await person.get("/device"))[0] == 200
            assert (await host.post(change, state="forgotten"))[0] == 400
            assert (await host.post(change, state="blocked"))[0] == 303
            assert (await person.get("/device"))[0] == 401
            assert (await host.post(change, state="active"))[0] == 303
            assert (await person.get("/device"))[0] == 401  # signed out

    asyncio.run(play())


def test_hosts_pages_are_no_worker_s(site: VerifySite) -> None:
    worker = site.worker()
    text = site.text(worker, failures=[FAILURE])
    page = f"/review/{text.text_id}"

    async def play() -> None:
        async with browsers(site, worker, site.host) as (person, host):
            for path in ("/review", page, f"{page}/walks/described", "/workers", "/ledger", "/ledger.csv"):
                assert (await person.get(path))[0] == 404
            for path in (f"{page}/accept", f"/workers/{worker.worker_id}/state"):
                assert (await person.post(path, version="1", state="active"))[0] == 404
                assert (await host.send(path, data={"csrf": person.csrf, "version": "1", "state": "paused"}))[0] == 403

    asyncio.run(play())
    assert site.store.texts.get(text.text_id).state == "in_review"
