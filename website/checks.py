"""Checks of the built site: what the generator does not look at.

Every link of the site's own and its anchor exist, pictures have descriptions, every page names its language and has one
title, and no page loads anything from another machine.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADS = {
    "script": "src",
    "img": "src",
    "source": "srcset",
    "iframe": "src",
    "video": "src",
    "audio": "src",
    "object": "data",
}
"""Attributes that make a browser load something, by element."""

LOADING_RELATIONS = {
    "stylesheet",
    "icon",
    "preload",
    "preconnect",
    "prefetch",
    "dns-prefetch",
    "manifest",
    "modulepreload",
}
"""Relations of `link` for which a browser sends a request."""


@dataclass
class Contents:
    """What the checks look at in a page.

    Attributes:
        language: of the page.
        anchors: ids of elements.
        links: targets of links.
        loaded: what a browser loads.
        undescribed: pictures without a description.
        titles: number of headings of the first level.
        moved: whether it only leads to another page.
    """

    language: str = ""
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)
    undescribed: list[str] = field(default_factory=list)
    titles: int = 0
    moved: bool = False


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.contents = Contents()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {name: value or "" for name, value in attrs}
        its = self.contents
        if "id" in named:
            its.anchors.add(named["id"])
        if tag == "html":
            its.language = named.get("lang", "")
        if tag == "h1":
            its.titles += 1
        if tag == "meta" and named.get("http-equiv") == "refresh":
            its.moved = True
        if tag == "a" and "href" in named:
            its.links.append(named["href"])
        if tag == "img" and not named.get("alt", "").strip():
            its.undescribed.append(named.get("src", ""))
        if tag in LOADS and named.get(LOADS[tag]):
            its.loaded.append(named[LOADS[tag]].split(" ")[0])
        if tag == "link" and LOADING_RELATIONS & set(named.get("rel", "").split()):
            its.loaded.append(named.get("href", ""))


def read(page: Path) -> Contents:
    """Return what the checks look at in a page."""
    reader = _Reader()
    reader.feed(page.read_text(encoding="utf-8"))
    return reader.contents


def problems(site: Path) -> list[str]:
    """Return what is wrong with a site, one line each.

    Args:
        site: the site's folder.
    """
    pages = {path.resolve(): read(path) for path in sorted(site.rglob("*.html"))}
    found = [f"{path.relative_to(site.resolve())}: {problem}" for path in pages for problem in _of(path, pages)]
    for style in sorted(site.rglob("*.css")):
        text = style.read_text(encoding="utf-8")
        found += [
            f"{style.relative_to(site)}: loads {part[:60]}"
            for part in text.split("url(")[1:]
            if _leaves(part.strip("\"' "))
        ]
    return found


def _of(path: Path, pages: dict[Path, Contents]) -> Iterator[str]:
    page = pages[path]
    if page.moved:
        return
    if not page.language:
        yield "names no language"
    if page.titles != 1 and path.name != "404.html":
        yield f"has {page.titles} titles, expected one"
    yield from (f"the picture {picture} has no description" for picture in page.undescribed)
    yield from (f"loads {target} from another machine" for target in page.loaded if _leaves(target))
    if path.name == "404.html":
        return
    for target in page.links + page.loaded:
        parts = urlsplit(target)
        if parts.scheme or parts.netloc:
            continue
        at = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        if at.is_dir():
            at /= "index.html"
        if not at.exists():
            yield f"the link {target} leads nowhere"
        elif parts.fragment and at in pages and unquote(parts.fragment) not in pages[at].anchors | {"__skip"}:
            yield f"the link {target} has no anchor"


def _leaves(target: str) -> bool:
    return target.startswith(("http:", "https:", "//"))
