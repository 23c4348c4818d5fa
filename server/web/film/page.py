"""A film as one HTML file that needs no server: the watch page with its style, modules, moments and frames inside."""

import base64
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from arramon_server.web.page_texts import PageTexts
from arramon_server.web.rendering import Renderer

STATIC = Path(__file__).parents[1] / "static"

MODULES = ("svg.js", "drive.js", "source.js", "stage.js", "main.js")
"""Modules of the watch page, each after those that it imports."""

_FACES = re.compile(r"@font-face \{[^}]*\}\n?")
_URLS = re.compile(r'url\("([^"]+)"\)')
_IMPORTS = re.compile(r"^import .*;\n", re.MULTILINE)
_EXPORTS = re.compile(r"^export ", re.MULTILINE)


def film_page(
    t: PageTexts, context: Mapping[str, Any], data: Mapping[str, Any], frames: Sequence[bytes], *, devanagari: bool
) -> bytes:
    """Return the file.

    Args:
        t: texts in the film's language.
        context: variables of `WatchPart.context`.
        data: moments and notes, as of `WatchPart.data`.
        frames: JPEG of each moment.
        devanagari: whether the fonts for Devanagari come along.
    """
    addresses = [data_address("image/jpeg", frame) for frame in frames]
    variables = {
        "watch": {**context, "here": "", "files": "", "frame": addresses[context["now"]["step"]], "is_film": True},
        "film": {"data": data, "frames": addresses},
        "style": _style(devanagari=devanagari),
        "script": _script(),
    }
    return Renderer().page("film.html", t, "/", variables)


def data_address(kind: str, content: bytes) -> str:
    """Return an address that holds a content of some type itself."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _style(*, devanagari: bool) -> str:
    style = (STATIC / "style.css").read_text(encoding="utf-8")
    if not devanagari:
        style = _FACES.sub("", style)
    style = _URLS.sub(lambda found: f'url("{data_address("font/woff2", (STATIC / found[1]).read_bytes())}")', style)
    return style + (STATIC / "watch" / "watch.css").read_text(encoding="utf-8")


def _script() -> str:
    """Return the modules as one."""
    texts = [(STATIC / "watch" / name).read_text(encoding="utf-8") for name in MODULES]
    return "\n".join(_EXPORTS.sub("", _IMPORTS.sub("", text)) for text in texts)
