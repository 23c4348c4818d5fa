"""The screening test before writing on a real server: two attempts, then an explanation and a pause."""

import re
from urllib.parse import urlencode

import pytest

from arramon_collecting.rules.screening import RIGHT_WRITE
from arramon_collecting.web.texts import texts_of
from tests.collecting.web.writing.conftest import site
from tests.collecting.web.writing.write_site import Answer, Writer, WriteSite
from tests.web.reading import Page

__all__ = ["site"]


def answer(writer: Writer, language: str = "en", **wrong: str) -> Answer:
    body = urlencode({**RIGHT_WRITE, **wrong, "csrf": writer.csrf}).encode()
    address = f"/{language}/collect/{writer.collection.name}/screening/write"
    return writer.request("POST", address, body, {"Content-Type": "application/x-www-form-urlencoded"})


@pytest.mark.parametrize("language", ["en", "hi"])
def test_right_answers_pass_once_and_for_all(site: WriteSite, language: str) -> None:
    writer = site.writer(language)
    site.store.workers.record_device(writer.worker.worker_id, {"keyboard": True})
    home = f"/{language}/collect/{writer.collection.name}/"
    asked = writer.request("GET", f"{home}screening/write")
    page = Page(asked.text)
    assert len(page.all("fieldset")) == len(RIGHT_WRITE)
    assert len([field for field in page.all("input") if field.get("type") == "radio"]) == 3 * len(RIGHT_WRITE)
    passed = answer(writer, language)
    assert passed.status == 303
    task = passed.headers["Location"]
    assert re.fullmatch(re.escape(home) + "write/[0-9a-f]{32}[?]passed", task)
    assert texts_of(language)("collect_screening.passed_write") in writer.request("GET", task).text
    assert site.store.workers.get(writer.worker.worker_id).screening["write"]["passed_at"]
    assert writer.request("GET", f"{home}screening/write").status == 303


def test_two_wrong_attempts_bring_an_explanation_and_a_pause(site: WriteSite) -> None:
    writer = site.writer()
    first = answer(writer, q1="a")
    assert first.status == 200
    assert "Attempts left: 1." in first.text
    assert first.text.count("Not right.") == 1
    second = answer(writer, q1="b", q2="b")
    assert "The test was not passed." in second.text
    assert "Walk past the green bench" in second.text, "the right answers are explained"
    assert "<form" not in second.text
    third = answer(writer)
    assert (third.status, "The test was not passed." in third.text) == (200, True)
    assert not site.store.workers.get(writer.worker.worker_id).screening["write"]["passed_at"]


def test_answers_from_elsewhere_do_not_count(site: WriteSite) -> None:
    writer = site.writer()
    writer.csrf = "forged"
    assert answer(writer).status == 403
    assert site.store.workers.get(writer.worker.worker_id).screening == {}
