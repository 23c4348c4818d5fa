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

TYPES = {".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
"""Content types of static files, by suffix."""


def breakable(name: str) -> markupsafe.Markup:
    """Return a name with line break opportunities after its punctuation, for narrow columns."""
    return markupsafe.Markup("<wbr>").join(filter(None, _WORDS.findall(name)))  # joining escapes the parts


class Renderer:
    """Renders the templates, and holds the static files in memory.

    Args:
        host: the host of the leaderboard, for the footer of every page.

    Attributes:
        files: name with digest, such as `style.0a1b2c3d4e.css` -> content and content type.
    """

    def __init__(self, host: Host = UNNAMED) -> None:
        self.files: dict[str, tuple[bytes, str]] = {}
        named = {}
        for path in sorted((_HERE / "static").iterdir()):
            if path.suffix in TYPES:
                content = path.read_bytes()
                name = f"{path.stem}.{hashlib.sha256(content).hexdigest()[:10]}{path.suffix}"
                self.files[name] = (content, TYPES[path.suffix])
                named[path.name] = f"/static/{name}"
        self._environment = jinja2.Environment(
            loader=jinja2.FileSystemLoader(_HERE / "templates"),
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
            "link_of": link_of,
            "breakable": breakable,
            "per_cent": lambda share: f"{100 * share:.1f}".removesuffix(".0"),
        }

    def page(self, template: str, texts: PageTexts, here: str, context: Mapping[str, Any]) -> bytes:
        """Render a page.

        Args:
            template: file name of the template.
            texts: of the page's language.
            here: the page's address after the language, starting with a slash.
            context: variables of the template.
        """
        return self._environment.get_template(template).render(t=texts, here=here, **context).encode()
