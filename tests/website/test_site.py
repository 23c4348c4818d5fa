"""The built site: without fault, complete, and of this machine alone."""

import argparse
import http.server
import json
import re
import threading
import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, expect

from tests import ROOT
from tests.web.conftest import browser as browser
from website import checks
from website.build import with_unbroken_names, without_empty_headers
from website.reference import api, commands, protocol
from website.staging import DOCS, Stage

REDIRECTS: dict[str, str] = json.loads((ROOT / "website" / "redirects.json").read_text(encoding="utf-8"))


def test_nothing_is_wrong_with_it(site: Path) -> None:
    assert checks.problems(site) == []


def test_old_addresses_lead_to_pages(site: Path) -> None:
    assert len(REDIRECTS) > 25
    for old, new in REDIRECTS.items():
        assert f'url={new}"' in (site / old).read_text(encoding="utf-8")
        assert (site / new).exists()


def test_public_names_are_in_the_reference(site: Path) -> None:
    anchors = {anchor for page in (site / "reference" / "api").glob("*.html") for anchor in checks.read(page).anchors}
    named = list(api.public_names())
    assert len(named) > 40
    assert [name for name in named if name not in anchors] == []


def test_pages_are_in_the_navigation() -> None:
    for settings, folder, own in (("zensical.toml", DOCS, "hi/"), ("hindi.toml", DOCS / "hi", None)):
        text = (ROOT / "website" / settings).read_text(encoding="utf-8").replace("@REFERENCE@", "")
        project = tomllib.loads(text)
        named = set(re.findall(r"'([^']+\.md)'", str(project.get("project", project)["nav"])))
        pages = {str(path.relative_to(folder)) for path in folder.rglob("*.md")}
        missing = {page for page in pages if not (own and page.startswith(own))} - named
        assert missing == set()


def test_options_of_all_commands_are_in_the_reference() -> None:
    text = {page.path: page.text for page in commands.pages()}
    client, server = text["reference/commands/client.md"], text["reference/commands/server.md"]
    for option in ("--agent-arg", "--resume", "--dry-run", "--token-file"):
        assert f"`{option} " in client or f"`{option}`" in client
    for command in ("serve", "generate", "collect", "token create", "config"):
        assert f"## arramon-server {command}\n" in server
    assert "`--bank-seconds" in server
    assert "`--smoke`" in text["reference/commands/train.md"]
    for parser in [*commands.client(), *commands.server()]:
        page = client if parser.prog.startswith("arramon-client") else server
        for action in parser._actions:
            shown = action.help != argparse.SUPPRESS and not isinstance(action, argparse._HelpAction)
            assert not shown or all(option in page for option in action.option_strings), action.option_strings


def test_the_protocols_comments_are_in_the_reference() -> None:
    pages = {page.title: page.text for page in protocol.pages()}
    for name, text in pages.items():
        source = (ROOT / "proto" / "arramon" / "v1" / name).read_text(encoding="utf-8")
        for kind, word in re.findall(r"^\s*(message|rpc|enum|service) (\w+)", source, re.MULTILINE):
            heading = {"service": f"## Service {word}\n", "rpc": f"### {word}\n"}.get(kind)
            assert (heading or f"{word}\n") in text, f"{name}: {kind} {word}"
    assert "| `page_size` = 3 | `uint32` | 0: 1000; at most 10000. |" in pages["evaluation.proto"]
    assert "`Play(stream PlayRequest) returns (stream PlayResponse)`" in pages["evaluation.proto"]
    assert "map<" in pages["types.proto"] + pages["evaluation.proto"] + pages["leaderboard.proto"]


def test_links_out_of_the_folder_lead_to_copies(tmp_path: Path) -> None:
    stage = Stage(tmp_path / "pages")
    page = tmp_path / "page.md"
    page.write_text(
        "[a](%s) and\n```\n[b](../README.md)\n```\n" % (ROOT / "examples" / "my_agent.py"), encoding="utf-8"
    )
    stage.add(page, Path("how-to/page.md"))
    text = (tmp_path / "pages" / "how-to" / "page.md").read_text(encoding="utf-8")
    assert text == "[a](../files/examples/my_agent.py) and\n```\n[b](../README.md)\n```\n"
    assert (tmp_path / "pages" / "files" / "examples" / "my_agent.py").exists()


GOOD = '<html lang="en"><h1 id="a">A</h1><a href="#a">a</a><img src="p.png" alt="A picture"></html>'

FAULTS = [
    ('<html lang="en">', "<html>", "names no language"),
    ("<h1", "<h2", "has 0 titles, expected one"),
    ("#a", "#b", "the link #b has no anchor"),
    ("#a", "none.html", "the link none.html leads nowhere"),
    ('alt="A picture"', 'alt=""', "the picture p.png has no description"),
    ("p.png", "https://example.org/p.png", "loads https://example.org/p.png from another machine"),
    ("</html>", '<link rel="stylesheet" href="//a/b.css"></html>', "loads //a/b.css from another machine"),
]


@pytest.mark.parametrize(("good", "bad", "problem"), FAULTS)
def test_faults_are_found(good: str, bad: str, problem: str, tmp_path: Path) -> None:
    (tmp_path / "p.png").touch()
    (tmp_path / "index.html").write_text(GOOD, encoding="utf-8")
    assert checks.problems(tmp_path) == []
    (tmp_path / "index.html").write_text(GOOD.replace(good, bad), encoding="utf-8")
    assert f"index.html: {problem}" in checks.problems(tmp_path)


@pytest.fixture
def address(site: Path) -> Iterator[str]:
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()


PAGES = (
    "index.html",
    "tutorials/play-an-agent.html",
    "reference/api/agent.html",
    "results/index.html",
    "hi/index.html",
)


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 1440])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_ask_no_other_machine_and_fit(address: str, browser: Browser, scheme: str, width: int) -> None:
    context = browser.new_context(
        color_scheme="dark" if scheme == "dark" else "light", viewport={"width": width, "height": 800}
    )
    page = context.new_page()
    asked: list[str] = []
    errors: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    for name in PAGES:
        page.goto(address + name)
        page.wait_for_load_state("networkidle")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
        assert page.evaluate("document.body.dataset.mdColorScheme") == {"light": "default", "dark": "slate"}[scheme]
        assert "Hind" in page.evaluate("getComputedStyle(document.querySelector('h1')).fontFamily")
        if name.startswith("hi/"):  # On other pages only hidden menus may have Devanagari, for which no font is loaded.
            assert page.evaluate("[...document.fonts].some(font => font.status == 'loaded')")
    context.close()
    assert len(asked) > len(PAGES)
    assert [url for url in asked if not url.startswith((address, "data:", "blob:"))] == []
    assert errors == []


NOT_OURS = {"landmark-unique"}
"""Rules of Axe that the theme breaks: two parts of its navigation have one name."""


WIDE_TABLES = ("SECURITY.html", "explanation/data.html", "how-to/upgrading.html")
"""Pages with tables that are wider than a phone, and with tables of which a header cell, or the whole row, is empty."""


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "width"), [("light", 1440), ("dark", 360)])
def test_axe_finds_nothing(address: str, browser: Browser, scheme: str, width: int) -> None:
    context = browser.new_context(
        color_scheme="dark" if scheme == "dark" else "light", viewport={"width": width, "height": 800}
    )
    page = context.new_page()
    for name in (*PAGES, *WIDE_TABLES):
        page.goto(address + name)
        page.wait_for_load_state("networkidle")
        found = {violation["id"] for violation in Axe().run(page).response["violations"]}
        assert found <= NOT_OURS, name
    context.close()


TABLES = [
    ("<thead>\n<tr>\n<th></th>\n<th></th>\n</tr>\n</thead>\n<tbody>", "<tbody>"),
    (
        '<thead><tr><th align="left"></th><th>a</th></tr></thead>',
        '<thead><tr><td align="left"></td><th>a</th></tr></thead>',
    ),
    ("<thead><tr><th>a</th></tr></thead>", "<thead><tr><th>a</th></tr></thead>"),
]


@pytest.mark.parametrize(("table", "expected"), TABLES)
def test_empty_header_cells_are_dropped(table: str, expected: str) -> None:
    assert without_empty_headers(table) == expected


def test_short_code_is_not_broken() -> None:
    option, command = "--checkpoint-steps", "arramon-client play --lang hi"
    text = f"<code>{option}</code> <code>{command}</code>"
    assert with_unbroken_names(text) == f'<code class="short">{option}</code> <code>{command}</code>'


@pytest.mark.slow
@pytest.mark.parametrize(("page", "word"), [("index.html", "nDTW"), ("hi/index.html", "लीडरबोर्ड")])
def test_search_finds(address: str, browser: Browser, page: str, word: str) -> None:
    tab = browser.new_context().new_page()
    tab.goto(address + page)
    tab.wait_for_load_state("networkidle")
    tab.keyboard.press("Control+k")
    expect(tab.locator("input:focus")).to_be_visible()
    tab.keyboard.type(word)
    tab.get_by_text(re.compile(r"^[1-9]\d* \S+$")).first.wait_for()
    tab.context.close()
