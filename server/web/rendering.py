"""Renders pages from templates and texts, and names static files by a digest of their content."""

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2
import markupsafe

from arramon_server import __version__
from arramon_server.web.host import UNNAMED, Host, link_of
from arramon_server.web.page_texts import PageTexts, all_texts

_WORDS = re.compile(r"[^_.:@]*[_.:@]*")
"""A word and the punctuation after it, where browsers would not break a line."""

_HERE = Path(__file__).parent

TYPES = {".woff2": "font/woff2", ".svg": "image/svg+xml", ".css": "text/css", ".js": "text/javascript"}
"""Content types of static files, by suffix. Style sheets come after what they refer to."""

_URL = re.compile(r'url\("([^"]+)"\)')
"""A reference in a style sheet to another static file, by its name in the folder `static`."""


def breakable(name: str) -> markupsafe.Markup:
    """Return a name with line break opportunities after its punctuation, for narrow columns."""
    return markupsafe.Markup("<wbr>").join(filter(None, _WORDS.findall(name)))  # joining escapes the parts


class Renderer:
    """Renders the templates, and holds the static files in memory.

    Args:
        host: the host of the leaderboard, for the footer of every page.
        offers_play: whether the pages link to the one on which people play.

    Attributes:
        files: name with digest, such as `style.0a1b2c3d4e.css`, or `play.0a1b2c3d4e/main.js` for a file in a folder,
            whose files keep their names, so that modules can import each other -> content and content type.
    """

    def __init__(self, host: Host = UNNAMED, *, offers_play: bool = False) -> None:
        self.files: dict[str, tuple[bytes, str]] = {}
        self._named = named = dict[str, str]()
        for path in _static_files(_HERE / "static"):
            content = _with_digests(path.read_bytes(), named) if path.suffix == ".css" else path.read_bytes()
            name = f"{path.stem}.{_digest(content)}{path.suffix}"
            self.files[name] = (content, TYPES[path.suffix])
            named[path.name] = f"/static/{name}"
        for folder in sorted(path for path in (_HERE / "static").iterdir() if path.is_dir()):
            self._add_static(folder.name, folder)
        self._folders = dict[str, jinja2.BaseLoader]()
        self._environment = jinja2.Environment(
            loader=jinja2.ChoiceLoader(
                [jinja2.FileSystemLoader(_HERE / "templates"), jinja2.PrefixLoader(self._folders)]
            ),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            auto_reload=False,
        )
        self._environment.globals |= {
            "static": named.__getitem__,
            "languages": list(all_texts().values()),
            "version": __version__,
            "host": host,
            "offers_play": offers_play,
            "link_of": link_of,
            "breakable": breakable,
            "per_cent": lambda share: f"{100 * share:.1f}".removesuffix(".0"),
        }

    def add_folder(self, name: str, folder: Path) -> None:
        """Add the templates and static files of a part of the pages.

        Args:
            name: first part of their names, such as "play" of the static file `play/main.js`.
            folder: contains the folders `templates` and `static`.
        """
        self._folders[name] = jinja2.FileSystemLoader(folder / "templates")
        self._add_static(name, folder / "static")

    def _add_static(self, name: str, folder: Path) -> None:
        contents = {
            path: _with_digests(path.read_bytes(), self._named) if path.suffix == ".css" else path.read_bytes()
            for path in _static_files(folder)
        }
        digest = _digest(b"".join(path.name.encode() + content for path, content in contents.items()))
        for path, content in contents.items():
            file = f"{name}.{digest}/{path.name}"
            self.files[file] = (content, TYPES[path.suffix])
            self._named[f"{name}/{path.name}"] = f"/static/{file}"

    def page(self, template: str, texts: PageTexts, here: str, context: Mapping[str, Any]) -> bytes:
        """Render a page.

        Args:
            template: file name of the template.
            texts: of the page's language.
            here: the page's address after the language, starting with a slash.
            context: variables of the template.
        """
        return self._environment.get_template(template).render(t=texts, here=here, **context).encode()


def _static_files(folder: Path) -> list[Path]:
    """Return the static files of a folder, those that style sheets may refer to first."""
    kinds = list(TYPES)
    found = [path for path in folder.iterdir() if path.suffix in TYPES]
    return sorted(found, key=lambda path: (kinds.index(path.suffix), path.name))


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:10]


def _with_digests(style: bytes, named: Mapping[str, str]) -> bytes:
    """Return a style sheet in which every `url("NAME")` is the address of the static file of that name."""
    return _URL.sub(lambda found: f'url("{named[found[1]]}")', style.decode()).encode()
