"""The site's files for programs, and the page that lists them."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence

from website.machine.openapi import openapi
from website.machine.schemas import schemas
from website.page import Page
from website.staging import DOCS

PURPOSES = ("tutorials", "how-to", "reference", "explanation", "results", "project")
"""Folders of pages, in the order of `llms.txt`."""


def files() -> Mapping[str, str]:
    """Return the content of each file by its path on the site."""
    found = {f"schemas/{name}.json": _as_json(schema) for name, schema in schemas().items()}
    return {**found, "openapi.json": _as_json(openapi()), "llms.txt": llms()}


def pages() -> Sequence[Page]:
    """Return the page that lists the schemas."""
    rows = "".join(
        f"| [`{name}.json`](../schemas/{name}.json) | {each['title']} |\n" for name, each in schemas().items()
    )
    text = (
        "# Schemas\n\nJSON Schema (2020-12) of the files that the project reads and writes. Those of data and"
        " settings are made from the models that read them. A test validates real files against all of them.\n\n"
        f"| schema | of |\n| --- | --- |\n{rows}\n"
        "[`openapi.json`](../openapi.json) describes the JSON of the server's pages (OpenAPI 3.1),"
        " [`llms.txt`](../llms.txt) lists these pages for language models.\n"
    )
    return [Page("reference/schemas.md", "Schemas", "All schemas", text)]


def llms() -> str:
    """Return the list of pages for language models (llmstxt.org): title and first sentence of each."""
    parts = ["# ArraMon\n", "> A benchmark for agents that follow instructions in a 3D world, in English and Hindi.\n"]
    for purpose in PURPOSES:
        lines = "\n".join(_listed(purpose))
        parts.append(f"## {purpose.capitalize()}\n\n{lines}\n")
    return "\n".join(parts)


def _listed(purpose: str) -> Iterator[str]:
    for path in sorted((DOCS / purpose).glob("*.md")):
        text = path.read_text(encoding="utf-8")
        title = re.search(r"^# (.+)$", text, re.MULTILINE)
        if title is None or path.stem == "index":
            continue
        first = next((part for part in text.split("\n\n") if re.match(r"(?!```)[A-Z`\[]", part)), "")
        plain = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", " ".join(first.split()))
        sentence = re.split(r"(?<=[.:]) ", plain)[0].rstrip(":")
        yield f"- [{title[1]}]({purpose}/{path.stem}.html)" + (f": {sentence}" if sentence else "")


def _as_json(content: object) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"
