"""Writing in a language that has nothing but names, letters, checks, and some of the pages' words."""

from contextlib import closing
from pathlib import Path
from textwrap import dedent

from tests.collecting.web.writing.write_site import WriteSite
from tests.collecting.writing.test_checks import QUALITY
from tests.lang.test_third_language import FILES

PAGE_WORDS = """
[collect_write]
title = "Verku instrukciojn"
[collect_write_checks]
interface = "Nur vi vidas {words}."
[collect_guidelines]
good_room = "Metu la punktitan bluan pilkon antaŭ la strian ruĝan tason."
"""

TEXTS = (
    "Iru rekte al la alta muro kaj prenu la strian ruĝan tason.",
    "Metu la strian ruĝan tason antaŭ la briko muro de la ĉambro.",
    "Turnu vin dekstren, iru rekte kaj prenu la bluan aĵon tie.",
    "Metu tiun bluan aĵon sur la strian ruĝan tason apud muro.",
)


def test_a_language_without_grammar_is_written_and_checked(tmp_path: Path) -> None:
    languages, words = tmp_path / "languages", tmp_path / "words"
    (languages / "eo").mkdir(parents=True)
    words.mkdir()
    for name in ("language", "lexicon", "relations"):
        (languages / "eo" / f"{name}.toml").write_text(dedent(FILES[name]))
    (languages / "eo" / "quality.toml").write_text(QUALITY)
    (words / "eo.toml").write_text(PAGE_WORDS)
    environment = {"ARRAMON_LANGUAGES": str(languages), "ARRAMON_COLLECT_TEXTS": str(words)}
    site = WriteSite(tmp_path / "data", environment=environment)
    with closing(site.database):
        writer = site.writer("eo")
        writer.page = writer.page.replace("/en/", "/eo/")
        page = writer.get().text
        assert "<h1>Verku instrukciojn</h1>" in page
        assert "The four texts" in page, "words that are missing are English"
        assert '<p class="example" lang="eo">Metu la punktitan bluan pilkon' in page
        writer.open()
        blocked = writer.submit(("Premu la klavo, iru rekte kaj prenu la strian ruĝan tason.", *TEXTS[1:]))
        assert blocked.status == 422
        assert blocked.json["findings"][0][0]["message"] == "Nur vi vidas “klavo”."
        answer = writer.submit(TEXTS)
        assert (answer.status, answer.json) == (200, {"next": f"/eo/collect/{writer.collection.name}/?notice=sent"})
        (text,) = site.store.texts.all(writer.collection.name)
        assert text.instructions == ((TEXTS[0], TEXTS[1]), (TEXTS[2], TEXTS[3]))
        assert [failure["severity"] for failure in text.failures if failure["severity"] == "hint"] == []
    assert site.stop() == 0
