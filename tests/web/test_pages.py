"""The pages over HTTP: content, languages, headers, and secrecy of hidden splits."""

import csv
import html
import io
import itertools
import json
import re
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_client.receipts import read_receipt
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.records import COMPLETE, CommitBatch, EpisodeEnding
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.web import page_texts, pages
from tests import tiny
from tests.dataset import recovered_split
from tests.played import play
from tests.web.leaderboard_site import (
    HIDDEN_RUN,
    OLDER_RUN,
    OPEN_RUN,
    PECULIAR,
    REPRODUCED_RUN,
    UNPUBLISHED_RUN,
    WITHDRAWN_RUN,
    LeaderboardSite,
)
from tests.web.reading import Page

GZIP = {"Accept-Encoding": "gzip"}


PAGES = (
    "/{t}/",
    "/{t}/?split=open&language=en",
    "/{t}/?split=open&language=both&turns=1&sort=ndtw",
    "/{t}/?split=hidden&language=hi",
    "/{t}/?split=hidden&language=both",
    "/{t}/?split=tiny&language=en",
    "/{t}/?split=open&language=en&sensors=privileged",
    f"/{{t}}/runs/{OPEN_RUN}",
    f"/{{t}}/runs/{HIDDEN_RUN}",
    f"/{{t}}/runs/{OPEN_RUN}/episodes/quokka-1",
    f"/{{t}}/runs/{OPEN_RUN}/failures",
    "/{t}/watch",
    "/{t}/epochs",
    "/{t}/?split=test_unseen_e2&language=en",
    f"/{{t}}/runs/{OLDER_RUN}",
    f"/{{t}}/runs/{REPRODUCED_RUN}",
)
EVERYWHERE = [page.format(t=t) for page in PAGES for t in ("en", "hi")]


@pytest.mark.parametrize(
    ("accepted", "address"), [("hi-IN,hi;q=0.9", "/hi/"), ("en", "/en/"), ("fr", "/en/"), (None, "/en/")]
)
def test_the_first_page_is_in_the_browsers_language(web: LeaderboardSite, accepted: str | None, address: str) -> None:
    got = web.site.get("/", {"Accept-Language": accepted} if accepted else None)
    assert (got.status, got.headers["location"], got.headers["vary"]) == (303, address, "Accept-Language")
    assert web.site.get("/?split=open").headers["location"] == "/en/?split=open"
    assert web.site.get("/hi?split=open").headers["location"] == "/hi/?split=open"
    assert web.site.get("/?a=%0d%0aX:%20y").headers["location"] == "/en/?a=%0d%0aX:%20y"


def test_every_page_has_valid_headings_ids_and_labels(shown: LeaderboardSite) -> None:
    for address in EVERYWHERE:
        got = shown.site.get(address)
        assert got.status == 200, address
        page = Page(got.text)
        language = address.split("/")[1]
        assert page.all("html")[0]["lang"] == language
        levels = [level for level, _ in page.headings]
        assert levels.count(1) == 1, address
        assert all(after - before <= 1 for before, after in itertools.pairwise(levels)), (address, levels)
        assert levels[0] == 1
        assert all(text.strip() for _, text in page.headings)
        assert len(page.all("caption")) == len(page.all("table"))
        assert all(cell.get("scope") for cell in page.all("th")), address
        for around, (tag, attributes) in zip(page.inside, page.elements, strict=True):
            if tag in ("select", "input") and attributes.get("type") != "hidden":
                assert "label" in around, (address, attributes)
            if tag == "svg":
                named = attributes.get("aria-label") or attributes.get("aria-labelledby")
                assert attributes.get("aria-hidden") == "true" or (attributes.get("role") == "img" and named)
            if attributes.get("class", "").startswith("scroll"):
                assert {"role", "tabindex", "aria-labelledby"} <= set(attributes)
        ids = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
        assert len(ids) == len(set(ids)), address
        labelled = [attributes["aria-labelledby"] for _, attributes in page.elements if "aria-labelledby" in attributes]
        assert set(labelled) <= set(ids), address


@pytest.fixture
def tamil(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A third language, by a third file alone."""
    shutil.copytree(page_texts.FOLDER, tmp_path / "texts")
    english = (tmp_path / "texts" / "en.toml").read_text()
    (tmp_path / "texts" / "ta.toml").write_text(english.replace('name = "English"', 'name = "தமிழ்"'))
    monkeypatch.setattr(page_texts, "FOLDER", tmp_path / "texts")
    page_texts.all_texts.cache_clear()
    yield
    page_texts.all_texts.cache_clear()


def test_language_is_added_to_the_pages_by_one_file(tamil: None, web: LeaderboardSite) -> None:
    assert web.site.get("/", {"Accept-Language": "ta-IN, hi;q=0.9"}).headers["location"] == "/ta/"
    assert Page(web.site.get("/ta/").text).all("html")[0]["lang"] == "ta"
    assert '<a href="/ta/" lang="ta" hreflang="ta">தமிழ்</a>' in web.site.get("/hi/").text


def test_pages_have_no_inline_code_and_no_external_resources(shown: LeaderboardSite) -> None:
    for address in EVERYWHERE:
        page = Page(shown.site.get(address).text)
        assert page.all("style") == []
        assert all("src" in script for script in page.all("script"))
        for _, attributes in page.elements:
            assert not [name for name in attributes if name == "style" or name.startswith("on")], address
        for link in page.addresses():
            assert re.match(r"[/?#]", link), (address, link)
            assert not link.startswith("//"), (address, link)


def test_every_internal_link_resolves(shown: LeaderboardSite) -> None:
    links = {link for address in EVERYWHERE for link in Page(shown.site.get(address).text).addresses()}
    paths = {link for link in links if link.startswith("/")} | {f"/en/{link}" for link in links if link.startswith("?")}
    assert len(paths) > 80
    forms = {f"/{t}/runs/{OPEN_RUN}/episodes" for t in ("en", "hi")}
    assert {path for path in paths - forms if shown.site.get(path).status != 200} == set()


@pytest.mark.parametrize("address", ["/en/", "/", "/static/x", "/en/nothing", "/standings.csv"])
def test_responses_have_security_headers(shown: LeaderboardSite, address: str) -> None:
    got = shown.site.get(address)
    policy = got.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert got.headers["x-content-type-options"] == "nosniff"
    assert got.headers["referrer-policy"] == "no-referrer"
    assert got.headers["server"] == "ArraMon"
    assert "set-cookie" not in got.headers
    assert "cache-control" in got.headers


def test_unchanged_page_is_not_sent_again(shown: LeaderboardSite) -> None:
    address = f"/en/runs/{OPEN_RUN}"
    first = shown.site.get(address)
    again = shown.site.get(address, {"If-None-Match": f'"other", {first.headers["etag"]}'})
    assert (again.status, again.body) == (304, b"")
    assert shown.site.get(address, {"If-None-Match": '"other"'}).status == 200
    assert shown.site.get(address, method="HEAD").headers["etag"] == first.headers["etag"]


@pytest.mark.parametrize(
    ("accepted", "coding"), [("gzip, br", "gzip"), ("br", None), ("gzip;q=0", None), ("", None), ("gzip;q=0.5", "gzip")]
)
def test_pages_are_compressed_if_accepted(shown: LeaderboardSite, accepted: str, coding: str | None) -> None:
    got = shown.site.get("/en/", {"Accept-Encoding": accepted})
    assert got.headers.get("content-encoding") == coding
    assert got.text.startswith("<!DOCTYPE html>")


def test_a_run_is_compared_with_the_others(web: LeaderboardSite) -> None:
    best, worse = web.published(1, 1.0, "best"), web.published(2, 0.5, "<worse>")
    text = web.site.get(f"/en/runs/{best}/against").text
    assert f'<a href="/en/runs/{worse}/against?language=en&amp;sort=ptc"><bdi>&lt;worse&gt;</bdi></a>' in text
    assert '<td class="score">+0.500 <small>+0.072 to +0.928</small></td>' in text
    assert '<td class="date">better</td>\n<td class="number">0.031</td><td class="number">0.031</td>' in text
    hindi = web.site.get(f"/hi/runs/{worse}/against?sort=ndtw").text
    assert '<td class="date">कमतर</td>' in hindi
    alone = web.site.get(f"/en/runs/{worse}/against?language=both").text
    assert "has no rank in these standings" in alone


def test_languages_side_by_side(web: LeaderboardSite) -> None:
    web.published(1, 1.0, "even", split="open")
    web.published(2, 1.0, "even", split="open", language="hi")
    web.published(3, 1.0, "uneven", split="open")
    web.published(4, 0.0, "uneven", split="open", language="hi")
    text = web.site.get("/en/?split=open&language=both&sort=gap").text
    assert text.index("<bdi>even</bdi>") < text.index("<bdi>uneven</bdi>")
    assert "<small>English over Hindi</small><small>same outcome: 0%</small>" in text
    assert "<small>same outcome: 100%</small>" in text
    least = web.site.get("/en/?split=open&language=both&sort=gap&least=0.6").text
    assert ("<bdi>even</bdi>" in least, "<bdi>uneven</bdi>" in least) == (True, False)
    assert 'name="least" value="0.6"' in least
    assert "Gap" not in web.site.get("/en/?split=open&language=en").text


def test_static_files_are_cached_permanently(shown: LeaderboardSite) -> None:
    links = [link for link in Page(shown.site.get("/en/").text).addresses() if link.startswith("/static/")]
    assert len(links) == 3
    for link in links:
        got = shown.site.get(link)
        assert (got.status, got.headers["cache-control"]) == (200, "public, max-age=31536000, immutable")
        assert got.headers["content-type"].partition(";")[0] in ("text/css", "text/javascript", "image/svg+xml")


@pytest.mark.parametrize(
    "path",
    [
        f"/en/runs/{UNPUBLISHED_RUN}",
        f"/en/runs/{WITHDRAWN_RUN}",
        f"/en/runs/{'e' * 32}",
        "/en/runs/short",
        "/en/runs/",
        f"/en/runs/{UNPUBLISHED_RUN}/episodes/quokka-1",
        f"/en/runs/{OPEN_RUN}/episodes/no-such-thing",
        f"/en/runs/{HIDDEN_RUN}/episodes/quokka-1",
        f"/en/runs/{HIDDEN_RUN}/episodes/no-such-thing",
        f"/en/runs/{HIDDEN_RUN}/episodes/quokka-1/moments.json",
        f"/runs/{HIDDEN_RUN}/episodes/quokka-1/frames/0.jpg",
        f"/en/runs/{HIDDEN_RUN}/failures",
        "/en/?split=nothing",
        "/en/?split=open&language=xx",
        "/en/?sort=';--",
        "/en/?split=tiny&language=en&page=2",
        "/xx",
        "/en/nothing/at/all",
        f"/en/runs/{UNPUBLISHED_RUN}/against",
        f"/en/runs/{OPEN_RUN}/against?sort=agent",
        f"/en/runs/{OPEN_RUN}/against?language=hi",
        "/static/style.css",
        "/static/..%2Fpages.py",
        f"/runs/{UNPUBLISHED_RUN}/receipt.json",
        f"/runs/{WITHDRAWN_RUN}/receipt.json",
        f"/runs/{'e' * 32}/receipt.json",
        f"/runs/{UNPUBLISHED_RUN}/actions.json",
        f"/runs/{HIDDEN_RUN}/actions.json",
        "/en/epochs?sort=best",
        "/standings.xml",
    ],
)
def test_missing_and_hidden_pages_give_identical_404_responses(shown: LeaderboardSite, path: str) -> None:
    got, nowhere = shown.site.get(path), shown.site.get("/en/nowhere")
    assert (got.status, got.body) == (404, nowhere.body)
    assert "There is no such page" in got.text
    assert set(got.headers) == set(nowhere.headers)


def test_missing_page_is_in_the_readers_language(shown: LeaderboardSite) -> None:
    assert "ऐसा कोई पृष्ठ नहीं है" in shown.site.get("/hi/runs/x").text
    assert "ऐसा कोई पृष्ठ नहीं है" in shown.site.get("/fr/", {"Accept-Language": "hi"}).text


def test_pages_reveal_nothing_of_hidden_episodes(shown: LeaderboardSite) -> None:
    hidden = [
        *(address for address in EVERYWHERE if "open" not in address and OPEN_RUN not in address),
        *(
            f"/{form}?split=hidden&language={code}"
            for form in ("standings.csv", "standings.json")
            for code in ("en", "both")
        ),
        f"/en/runs/{HIDDEN_RUN}/against",
        f"/en/runs/{HIDDEN_RUN}/episodes",
        f"/en/runs/{HIDDEN_RUN}/episodes?episode=quokka-1",
        f"/en/runs/{HIDDEN_RUN}/episodes/quokka-1",
        f"/en/runs/{HIDDEN_RUN}/episodes/quokka-1/moments.json",
        f"/en/runs/{HIDDEN_RUN}/failures",
    ]
    for address in hidden:
        got = shown.site.get(address)
        said = got.text + ("" if "episode" in address else str(got.headers))
        assert [word for word in PECULIAR if word in said] == [], address
    # The same words are on the pages of the same episodes where they are open, so they would have been found.
    said = shown.site.get(f"/en/runs/{OPEN_RUN}").text + shown.site.get(f"/en/runs/{OPEN_RUN}/episodes/quokka-1").text
    assert {word for word in PECULIAR if word not in said} == {"रेतघड़ी"}


def test_hidden_split_receipt_has_only_public_episode_fields(shown: LeaderboardSite) -> None:
    """It chains actions by episode, whose ids every participant is given; nothing else of them is in it."""
    got = shown.site.get(f"/runs/{HIDDEN_RUN}/receipt.json")
    payload = json.loads(json.loads(got.text)["payload"])
    assert {key for episode in payload["episodes"] for key in episode} == {"episode_id", "head", "ending"}
    assert [word for word in PECULIAR[1:] if word in got.text] == []


def test_downloaded_receipt_is_readable_by_the_client(shown: LeaderboardSite, tmp_path: Path) -> None:
    got = shown.site.get(f"/runs/{OPEN_RUN}/receipt.json")
    file = tmp_path / "it.receipt.json"
    file.write_bytes(got.body)
    receipt = read_receipt(file)
    assert receipt.run["run_id"] == OPEN_RUN
    assert receipt.public_key.hex() in shown.site.get(f"/en/runs/{OPEN_RUN}").text
    assert got.headers["content-disposition"] == f'attachment; filename="{OPEN_RUN}.receipt.json"'


def test_names_are_escaped_in_html(shown: LeaderboardSite) -> None:
    text = shown.site.get("/en/?split=open&language=hi").text
    assert "&lt;i&gt;lab&lt;/i&gt;" in text
    assert "<i>" not in text


def test_combined_standings_show_runs_of_both_languages(shown: LeaderboardSite) -> None:
    text = shown.site.get("/en/?split=open&language=both").text
    assert "all languages together" in text
    assert ("0.750" in text, "<bdi>truth</bdi>" in text) == (True, False)
    assert [f"/en/runs/{number:032x}" in text for number in (1, 2)] == [True, True]


def test_standings_show_ranks_ties_and_marks(web: LeaderboardSite) -> None:
    for number, (agent, score) in enumerate({"best": 1.0, "worse": 0.5}.items(), start=1):
        web.published(number, score, agent)
    web.publish(web.run(f"{9:032x}", agent="seer", sensors=("oracle",)))
    first = web.site.get("/en/?split=tiny&language=en").text
    assert re.findall(r'<tr>\n<td class="number rank pin">(.*?)</td>', first)[:2] == ["1", "2"]
    web.published(3, 1.0, "as-good")  # six episodes do not show so much of three runs
    text = web.site.get("/en/?split=tiny&language=en").text
    ranks = re.findall(r'<tr>\n<td class="number rank pin">(.*?)</td>', text)
    shared = '1<span class="tie" aria-hidden="true">=</span><span class="hidden"> shared</span>'
    shared += '<small><span class="hidden">could be any of </span>1–3</small>'
    apart = '<span aria-hidden="true">–</span><span class="hidden">not ranked</span>'
    assert ranks == [shared, shared, shared, apart]
    assert '<span class="mark">privileged</span>' in text


def test_runs_with_other_clocks_are_marked_on_every_page(web: LeaderboardSite) -> None:
    run = web.publish(web.run(f"{1:032x}", clocks=ClockSettings()))
    for language, mark in (("en", "other clocks"), ("hi", "अन्य घड़ियाँ")):
        for address in (f"/{language}/?split=tiny&language=en", f"/{language}/runs/{run}"):
            assert f'<span class="mark">{mark}</span>' in web.site.get(address).text, address


def test_only_the_sorted_column_has_aria_sort(shown: LeaderboardSite) -> None:
    for address, column, order in [
        ("/en/?split=open&language=en", "PTC", "descending"),
        ("/en/?split=open&language=en&sort=agent&order=asc", "Agent", "ascending"),
    ]:
        text = shown.site.get(address).text
        (found,) = re.findall(r'aria-sort="(\w+)"><a [^>]*>(\w+)', text)
        assert found == (order, column)


def test_paper_results_are_marked_as_other_data(web: LeaderboardSite) -> None:
    web.restart(val_seen=web.splits["tiny"])
    page = Page(web.site.get("/en/?split=val_seen&language=hi").text)
    said = " ".join(" ".join(page.words).split())
    assert "From the paper, with English instructions: measured on other data" in said
    for name in ("V/L", "V/O", "L/O", "R/W", "S/P", "H/W"):
        assert f"({name}) paper" in said
    assert "0.135" in said


def test_an_empty_board_says_how_to_publish_a_run(web: LeaderboardSite) -> None:
    text = web.site.get("/hi/?split=tiny&language=hi").text
    assert "arramon-client --agent agents.random_walk --split tiny --lang hi" in text
    assert "arramon-client publish RUN" in text
    page = Page(text)
    assert [level for level, _ in page.headings] == [1]  # no table: nothing to download, nothing to read
    assert not [link for link in page.addresses() if link.startswith("/standings")]


@pytest.mark.parametrize(("page", "said"), [
    ("/en/?split=tiny&language=en", "Published runs on this split in other languages:"),
    ("/hi/?split=tiny&language=en", "इस विभाजन पर दूसरी भाषाओं के प्रकाशित रन:"),
])  # fmt: skip
def test_a_list_without_runs_links_to_the_languages_that_have_some(web: LeaderboardSite, page: str, said: str) -> None:
    assert said not in web.site.get(page).text
    web.published(1, 0.5, "a", language="hi", participant="ann")
    web.published(2, 0.5, "b", language="hi", participant="bob")
    text = web.site.get(page).text
    assert said in text
    ((link, number),) = re.findall(r'<a href="([^"]+)">[^<]+ \((\d)\)</a>', text)
    assert number == "2"
    other = web.site.get(page.partition("?")[0] + html.unescape(link)).text
    assert re.findall(r"<bdi>([ab])</bdi></a>", other) == ["a", "b"]
    assert said not in other


def test_long_standings_are_split_into_pages(web: LeaderboardSite, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arramon_server.web.standings_page.PAGE_SIZE", 2)
    for number in range(1, 4):
        web.published(number, number / 10, f"agent-{number}")
    first, second = (web.site.get(f"/en/?split=tiny&language=en&page={page}").text for page in (1, 2))
    assert re.findall(r"<bdi>agent-(\d)", first) == ["3", "2"]
    assert re.findall(r"<bdi>agent-(\d)", second) == ["1"]
    assert 'aria-current="page">2<' in second


def test_standings_can_be_downloaded_as_csv_and_json(shown: LeaderboardSite) -> None:
    got = shown.site.get("/standings.csv?split=open&language=en&sort=ndtw")
    assert got.headers["content-type"] == "text/csv; charset=utf-8"
    assert got.headers["content-disposition"] == 'attachment; filename="arramon-open-en.csv"'
    assert [row["agent"] for row in csv.DictReader(io.StringIO(got.text))] == ["truth", "both-hands"]
    document = json.loads(shown.site.get("/standings.json?split=open&language=both").text)
    assert [line["agent"] for line in document["standings"]] == ["both-hands"]


def test_run_page_shows_signature_arguments_and_data_hash(shown: LeaderboardSite) -> None:
    text = shown.site.get(f"/en/runs/{OPEN_RUN}").text
    assert shown.board.entry(OPEN_RUN).signature in text
    assert shown.board.entry(OPEN_RUN).signature.endswith("|args:beam=4+checkpoint=my%20w.pt")
    assert "<dt>Agent&#39;s arguments</dt><dd>beam=4, checkpoint=my w.pt</dd>" in text
    assert f"{shown.splits['open'].data_hash}" in text
    assert f"arramon-client verify {OPEN_RUN}.receipt.json --key " in text
    assert "The server never had to offer an episode again." in text


def test_perfectly_played_path_is_drawn_on_the_ground_truth(shown: LeaderboardSite) -> None:
    page = Page(shown.site.get(f"/en/runs/{OPEN_RUN}/episodes/quokka-1").text)
    lines = {
        attributes["class"]: attributes["points"]
        for attributes in page.all("polyline")
        if "halo" not in str(attributes)
    }
    assert lines["truth"] == lines["played"] == "26.44,24 27.44,24 28.44,24"


def drawn(web: LeaderboardSite, run: str, episode: str) -> list[str]:
    """The paths played that an episode's page draws, one for each turn that was begun."""
    lines = Page(web.site.get(f"/en/runs/{run}/episodes/{episode}").text).all("polyline")
    return [str(line["points"]) for line in lines if line["class"] == "played" and "points" in line][1:]


def test_timed_out_and_faulty_episodes_are_drawn_as_scored(web: LeaderboardSite) -> None:
    run, first_turn = "e" * 32, tiny.ACTIONS[:3]
    actions = {f"quokka-{number}": first_turn for number in range(3)}
    ended = {"quokka-0": causes.TIME_LIMIT, "quokka-1": causes.FORFEITED}
    play(web.database, web.splits["open"], run, actions, ended=ended, over=False)
    unplayed = [dict.fromkeys(METRICS, 0.0)] * 2
    web.journal.commit(CommitBatch(endings=[EpisodeEnding(run, "quokka-2", causes.SERVER_FAULT, 0, unplayed, fence=1)]))
    web.journal.set_state(run, COMPLETE)
    web.publish(run)
    walked = "26.44,26 26.44,25 26.44,24"
    assert drawn(web, run, "quokka-0") == [walked, "26.44,24"]  # at the end of the time the second turn begins, too
    assert drawn(web, run, "quokka-1") == [walked]
    assert drawn(web, run, "quokka-2") == ["26.44,26"]  # its steps are in the journal, and do not count


def test_episode_search_redirects_to_the_episode_page(shown: LeaderboardSite) -> None:
    got = shown.site.get(f"/hi/runs/{OPEN_RUN}/episodes?episode=quokka-1")
    assert (got.status, got.headers["location"]) == (303, f"/hi/runs/{OPEN_RUN}/episodes/quokka-1")
    strange = shown.site.get(f"/hi/runs/{OPEN_RUN}/episodes?episode=//evil.example/%0d%0aX:%20y")
    assert strange.headers["location"] == f"/hi/runs/{OPEN_RUN}/episodes/%2F%2Fevil.example%2F%0D%0AX%3A%20y"


def test_paths_are_not_drawn_on_other_data(web: LeaderboardSite) -> None:
    web.fill()
    web.restart(open=web.splits["tiny"])
    text = web.site.get(f"/en/runs/{OPEN_RUN}").text
    assert ("so the paths cannot be drawn" in text, "other data" in text) == (True, True)
    assert web.site.get(f"/en/runs/{OPEN_RUN}/episodes/quokka-1").status == 404


def test_standings_page_stays_below_its_size_limit(web: LeaderboardSite) -> None:
    for number in range(1, 31):
        web.published(number, number / 31, f"an-agent-with-a-long-name-{number}")
    page = web.site.get("/hi/?split=tiny&language=en", GZIP)
    loaded = [web.site.get(link, GZIP) for link in Page(page.text).addresses() if link.startswith("/static/")]
    assert page.text.count("<svg") == 30 * 7
    assert page.size + sum(got.size for got in loaded) < 30_000
    assert sum(got.size for got in loaded if "javascript" in got.headers["content-type"]) < 5_000


def test_excess_concurrent_requests_get_status_503(shown: LeaderboardSite, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "MAX_WAITING", 0)
    got = shown.site.get("/hi/")
    assert (got.status, got.headers["retry-after"], got.headers["cache-control"]) == (503, "2", "no-store")
    assert "थोड़ी देर में" in got.text


def test_database_failure_shows_an_error_page_without_details(web: LeaderboardSite) -> None:
    with web.database.write() as connection:
        connection.exec_driver_sql("ALTER TABLE leaderboard_entries RENAME TO away")
    got = web.site.get("/en/")
    assert (got.status, got.headers["cache-control"], got.headers["retry-after"]) == (503, "no-store", "2")
    page = Page(got.text)
    assert page.headings == [(1, "This page is not available at the moment")]
    assert "The standings cannot be read at the moment. Please try again shortly." in page.words
    assert "away" not in got.text
    assert Page(web.site.get("/hi/").text).all("html")[0]["lang"] == "hi"


def test_slow_drawing_does_not_block_other_pages(shown: LeaderboardSite, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(*_: object) -> None:
        begun.set()
        go_on.wait(120)

    monkeypatch.setattr("arramon_server.web.section_map.draw_section", slow)
    drawing = threading.Thread(target=shown.site.get, args=(f"/en/runs/{OPEN_RUN}/episodes/quokka-1",))
    drawing.start()
    try:
        assert begun.wait(120)
        assert shown.site.get("/en/").status == 200
    finally:
        go_on.set()
        drawing.join(120)


def test_recovered_furniture_is_marked_on_the_map_of_an_episode(web: LeaderboardSite) -> None:
    web.restart(own=recovered_split.write(web.folder))
    run = web.play("e" * 32, "own")
    for language, key in (("en", "recovered landmark: the texts"), ("hi", "पता लगाई गई पहचान की चीज़")):
        page = web.site.get(f"/{language}/runs/{run}/episodes/0").text
        assert key in page
        assert page.count('<circle class="told"') == 1  # of the key
        agreed, told = (page.partition(f'<g class="{name}">')[2].partition("</g>")[0] for name in ("agreed", "told"))
        assert (agreed.count("<circle"), told.count("<circle")) == (2, 1)
        assert "31" in agreed
        plain = web.site.get(f"/{language}/runs/{run}/episodes/1").text
        assert 'class="told" cx="16"' not in plain  # an episode without furniture of its own
