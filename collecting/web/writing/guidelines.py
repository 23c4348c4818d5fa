"""Variables of the template with rules and examples for writers."""

from typing import Any

from arramon_collecting.storage.records import Collection
from arramon_collecting.web.texts import texts_of
from arramon_lang import load
from arramon_server.errors import NotFound
from arramon_server.web.page_texts import PageTexts


def guidelines_context(t: PageTexts, collection: Collection, *, is_open: bool) -> dict[str, Any]:
    """Return the variables of `write/guidelines.html`.

    Args:
        t: texts in the page's language, in which the rules are.
        collection: its language is that of the examples, or the page's if the pages have no texts in it.
        is_open: whether the rules are shown at once.
    """
    return {"examples": written_texts(t, collection), "written": load(collection.language).name, "opens_rules": is_open}


def written_texts(t: PageTexts, collection: Collection) -> PageTexts:
    """Return texts in the language that is written; the page's if the pages have none in it."""
    try:
        return texts_of(collection.language)
    except NotFound:
        return t
