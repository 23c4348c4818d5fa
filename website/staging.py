"""Copies of the repository's pages for the generator: links to files outside `docs/` lead to copies of them.

In the repository a page links to any file beside it, as an editor or a code host expects. On the site only what lies in
the folder of pages exists, so that files which pages link to are copied to `files/`, with their paths.
"""

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

DOCS = ROOT / "docs"

HINDI = "hi"
"""Folder of the Hindi pages, in `docs/` and on the site."""

ROOT_PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
"""Pages of the repository's root that are pages of the site."""

FRONT = {"README.md": "index.md"}
"""Pages that have others in their place on the site."""

FILES = "files"
"""Folder of the site with copies of the repository's files."""

LINK = re.compile(r"(?P<before>!?\[(?:[^\[\]]|\[[^\]]*\])*\]\()(?P<target>[^)\s]+)(?P<after>[^)]*\))")
ATTRIBUTE = re.compile(r"(?P<before>\b(?:src|href|srcset)=\")(?P<target>[^\"]+)(?P<after>\")")
FIGURE = re.compile(r"^!\[[^\]]*\]\(([^)\s]+\.svg)\)$")
"""A figure in a line of its own; on the site it is a link to itself, to be seen in its whole size."""

FENCE = re.compile(r"^ *(```|~~~)")
EXTERNAL = re.compile(r"[a-z]+:|#|//")


class Stage:
    """A folder of pages of one language for the generator.

    Args:
        pages: the folder, which is made.
        hindi: whether its pages are the Hindi ones.
    """

    def __init__(self, pages: Path, *, hindi: bool = False) -> None:
        self.pages = pages
        self.hindi = hindi
        self._copied: set[Path] = set()
        pages.mkdir(parents=True)

    def add_docs(self) -> None:
        """Copy the pages of the language; with the English ones those of the repository's root."""
        for path in files_of(DOCS):
            name = path.relative_to(DOCS)
            if self.hindi and name.parts[0] == HINDI:
                self.add(path, name.relative_to(HINDI))
            elif not self.hindi and name.parts[0] != HINDI:
                self.add(path, name)
        for page in () if self.hindi else ROOT_PAGES:
            self.add(ROOT / page, Path(page))

    def add(self, source: Path, name: Path) -> None:
        """Copy a file of the repository; in pages, links are changed to what the site has.

        Args:
            source: the file.
            name: its path in the folder of pages.
        """
        target = self.pages / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.suffix == ".md":
            target.write_text(self._rewritten(source, name), encoding="utf-8")
        else:
            shutil.copy(source, target)

    def _rewritten(self, source: Path, name: Path) -> str:
        lines, fenced = [], False
        for line in source.read_text(encoding="utf-8").split("\n"):
            if FENCE.match(line):
                fenced = not fenced
            lines.append(line if fenced else self._line(line, source, name))
        return "\n".join(lines)

    def _line(self, line: str, source: Path, name: Path) -> str:
        def link(found: re.Match[str]) -> str:
            target = found["target"]
            if EXTERNAL.match(target):
                return found[0]
            path, _, anchor = target.partition("#")
            at = self._place((source.parent / path).resolve())
            if at is None:  # The generator reports the broken link.
                return found[0]
            relative = os.path.relpath(at, name.parent)
            return found["before"] + relative + (f"#{anchor}" if anchor else "") + found["after"]

        return FIGURE.sub(r"[\g<0>](\g<1>)", ATTRIBUTE.sub(link, LINK.sub(link, line)))

    def _place(self, path: Path) -> Path | None:
        """Return where a file of the repository is in the folder of pages, copying it if need be; None if it is not."""
        if not path.is_relative_to(ROOT) or not path.exists():
            return None
        name = path.relative_to(ROOT)
        if str(name) in FRONT or str(name) in ROOT_PAGES:
            return self._on_the_site(Path(FRONT.get(str(name), str(name))))
        if path.is_relative_to(DOCS):
            return self._on_the_site(path.relative_to(DOCS))
        if path.is_dir():
            path = path / "README.md" if (path / "README.md").exists() else path / "__init__.py"
            name = path.relative_to(ROOT)
        place = Path(FILES) / name
        if path not in self._copied and path.exists():
            self._copied.add(path)
            self.add(path, place)
        return place

    def _on_the_site(self, name: Path) -> Path:
        """Return where a page of either language is, seen from the root of this one's.

        The two languages are made separately: a page of the other one is named by its address.
        """
        is_hindi = name.parts[0] == HINDI
        if is_hindi == self.hindi:
            return name.relative_to(HINDI) if is_hindi else name
        return (Path() if is_hindi else Path("..")) / name.with_suffix(".html" if name.suffix == ".md" else name.suffix)


def files_of(folder: Path) -> Iterator[Path]:
    """Yield the files in a folder and its subfolders, in order."""
    yield from sorted(path for path in folder.rglob("*") if path.is_file())
