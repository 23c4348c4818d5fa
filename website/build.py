"""The build of the site: pages are staged, generated ones are added, the generator runs, and its result is checked."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from website.generated import Page, generated_pages
from website.machine.files import files
from website.staging import HINDI, ROOT, Stage

HERE = Path(__file__).resolve().parent

FONTS = ROOT / "server" / "web" / "static"
"""Folder of the fonts and the icon that the server's pages use, too."""

ASSETS = (
    FONTS / "hind-400.woff2", FONTS / "hind-600.woff2", FONTS / "hind-LICENSE.txt", FONTS / "icon.svg",
    HERE / "static" / "site.css", HERE / "static" / "scrolling_tables.js",
)  # fmt: skip


CITING = "project/citing.html"
"""Page on citing and the licence, to which the footer of each page links."""


class BuildError(Exception):
    """The site could not be built; the message says why."""


def build(site: Path) -> None:
    """Build the site.

    Args:
        site: folder of the site; what is in it is removed.

    Raises:
        BuildError: if the generator finds fault with a page.
    """
    with tempfile.TemporaryDirectory(prefix="arramon-docs-") as folder:
        work = Path(folder)
        pages = generated_pages()
        english = Stage(work / "en" / "pages")
        english.add_docs()
        _add(english, pages)
        for name, text in files().items():
            (english.pages / name).parent.mkdir(exist_ok=True)
            (english.pages / name).write_text(text, encoding="utf-8")
        made = _generate(work / "en", _english(pages))
        hindi = Stage(work / HINDI / "pages", hindi=True)
        hindi.add_docs()
        _add(hindi, ())
        shutil.copytree(_generate(work / HINDI, _hindi()), made / HINDI)
        _link_citing(made)
        _improve_markup(made)
        _redirect(made)
        shutil.rmtree(site, ignore_errors=True)
        shutil.copytree(made, site)


def _add(stage: Stage, pages: Sequence[Page]) -> None:
    for page in pages:
        target = stage.pages / page.path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(page.text, encoding="utf-8")
    assets = stage.pages / "assets"
    assets.mkdir(exist_ok=True)
    for path in ASSETS:
        shutil.copy(path, assets)


def _english(pages: Sequence[Page]) -> str:
    """Return the settings of the English site."""
    sections: dict[str, list[str]] = {}
    for page in pages:
        if page.section:
            sections.setdefault(page.section, []).append(f"{{ {json.dumps(page.title)} = {json.dumps(page.path)} }}")
    nav = ",\n".join(f"{{ {json.dumps(section)} = [{', '.join(its)}] }}" for section, its in sections.items())
    return _settings({"@HOME@": "", "@REFERENCE@": nav, "@ROOT@": str(ROOT), "@CITE@": "cite and licence"})


def _hindi() -> str:
    """Return the settings of the Hindi site: those of the English one, with its own language and navigation."""
    text = _settings({"@HOME@": "../", "@REFERENCE@": "", "@ROOT@": str(ROOT), "@CITE@": "उद्धरण और लाइसेंस, अंग्रेज़ी में"})
    before, nav = text.index("nav = ["), text.index("[project.theme]")
    own = (HERE / "hindi.toml").read_text(encoding="utf-8")
    return text[:before] + own + "\n" + text[nav:].replace('language = "en"', f'language = "{HINDI}"', 1)


def _settings(values: dict[str, str]) -> str:
    text = (HERE / "zensical.toml").read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(name, value)
    return text


def _generate(folder: Path, settings: str) -> Path:
    """Run the generator in a folder, and return the folder of the site that it made."""
    (folder / "zensical.toml").write_text(settings, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=folder, capture_output=True, text=True, check=False, env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip
    if done.returncode:
        said = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
        raise BuildError(said.partition("Traceback")[0].strip() or said.strip())
    return folder / "site"


def _link_citing(site: Path) -> None:
    """Make the footer's link lead to the page on citing: the generator has one text for pages of all folders."""
    for page in site.rglob("*.html"):
        address = os.path.relpath(site / CITING, page.parent)
        text = page.read_text(encoding="utf-8")
        page.write_text(text.replace("@CITING@", address), encoding="utf-8")


EMPTY_HEADER_ROW = re.compile(r"<thead>\s*<tr>(\s*<th[^>]*></th>)+\s*</tr>\s*</thead>\s*")
EMPTY_HEADER = re.compile(r"<th([^>]*)></th>")


def without_empty_headers(text: str) -> str:
    """Return a page without empty header cells of tables, which screen readers would announce.

    Markdown gives each table a header row. One without text is removed, and a single empty cell becomes a plain one.
    """
    return EMPTY_HEADER.sub(r"<td\1></td>", EMPTY_HEADER_ROW.sub("", text))


SHORT_CODE = re.compile(r"<code>([^<]{1,24})</code>")


def with_unbroken_names(text: str) -> str:
    """Return a page on which short inline code, such as an option, has the class that prevents line breaks in it."""
    return SHORT_CODE.sub(r'<code class="short">\1</code>', text)


def _improve_markup(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        page.write_text(with_unbroken_names(without_empty_headers(text)), encoding="utf-8")


def _redirect(site: Path) -> None:
    """Write a page at each old address that leads to the new one."""
    for old, new in json.loads((HERE / "redirects.json").read_text(encoding="utf-8")).items():
        target = site / old
        if target.exists():
            raise BuildError(f"redirects.json: {old} is a page")
        if not (site / new).exists():
            raise BuildError(f"redirects.json: {old} leads to {new}, which is no page")
        target.write_text(
            f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Moved</title>'
            f'<meta http-equiv="refresh" content="0; url={new}"><link rel="canonical" href="{new}">'
            f'<p>This page has moved to <a href="{new}">{new}</a>.</p></html>\n',
            encoding="utf-8",
        )
