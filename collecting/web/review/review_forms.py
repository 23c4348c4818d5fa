"""What a host writes in the review: mended texts, and reasons. Problems are said in the page's language."""

from collections.abc import Mapping

from arramon_client.world import PHASES, TURNS
from arramon_collecting.rules.clean_text import clean_instructions
from arramon_collecting.rules.flags import KINDS
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.texts.records import Instructions
from arramon_collecting.writing.characters import invisible_in, pictures_in
from arramon_server.errors import BadInput
from arramon_server.web.page_texts import PageTexts


class ReviewFormError(BadInput):
    """A form that a host can correct; the message is in the page's language."""


def mended_instructions(t: PageTexts, collection: Collection, fields: Mapping[str, str]) -> Instructions:
    """Return the texts that a host has mended.

    Args:
        t: texts of the page's language.
        collection: the collection.
        fields: fields of the form, such as "1-navigation".

    Raises:
        ReviewFormError: if a text is empty, too long, or has characters that no text may have.
        BadInput: if it is malformed in a way that a browser does not send.
    """
    given = [[fields.get(f"{turn}-{phase}", "") for phase in PHASES] for turn in range(1, TURNS + 1)]
    for turn, pair in enumerate(given, start=1):
        for phase, text in zip(PHASES, pair, strict=True):
            if problem := _problem(t, collection, text):
                raise ReviewFormError(f"{t('path.turn', turn=turn)}, {t(f'path.{phase}')}: {problem}")
    return clean_instructions(given, collection.settings.max_characters)


def reason_of(t: PageTexts, fields: Mapping[str, str]) -> str:
    """Return the reason: the boxes that were ticked, and what was written.

    Raises:
        ReviewFormError: if there is none.
    """
    ticked = ", ".join(kind for kind in KINDS if f"flag-{kind}" in fields)
    written = " ".join(fields.get("reason", "").split())
    found = ": ".join(filter(None, (ticked, written)))
    if not found:
        raise ReviewFormError(t("collect_review_text.reason_missing"))
    return found


def _problem(t: PageTexts, collection: Collection, text: str) -> str:
    """Return what is wrong with a text; empty if it is good."""
    most = collection.settings.max_characters
    if not text.strip():
        return t("collect_write_js.write_first")
    if len(text) > most:
        return t("collect_write_checks.too_long", expected=most)
    for name, letters in (("picture", pictures_in(text)), ("invisible", invisible_in(text, collection.language))):
        if letters:
            shown = ", ".join(letter if letter.isprintable() else f"U+{ord(letter):04X}" for letter in letters)
            return t(f"collect_write_checks.{name}", words=shown)
    return ""
