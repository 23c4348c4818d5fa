"""Sentences of the pages' language for what the checks find."""

from typing import Any

from arramon_collecting.writing.checks import Finding
from arramon_server.sim.catalogue import ObjectType
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts

TERM_REASONS = {
    "key": "interface",
    "arrow": "interface",
    "black outline": "interface",
    "step": "term_count",
    "time": "term_count",
    "go back": "earlier",
    "return": "earlier",
    "came": "earlier",
    "item": "term_vague",
    "tile": "term_room",
    "grid": "term_room",
    "space": "term_room",
    "corner": "term_room",
    "go": "movement",
    "move": "movement",
}
"""Texts that say why a term cannot be used, by the paper's name of it. Languages may have further terms."""


def finding_as_json(t: PageTexts, finding: Finding, text: str, target: ObjectType) -> dict[str, Any]:
    """Return a finding for the page: with a sentence, and its marks counted as scripts count, in UTF-16.

    Args:
        t: texts in the page's language.
        finding: the finding.
        text: the checked text.
        target: the object that the text is about.
    """
    return {
        "check": finding.check,
        "severity": finding.severity,
        "message": sentence(t, finding, target),
        "marks": [[_utf16_length(text[:start]), _utf16_length(text[:end])] for start, end in finding.marks],
    }


def sentence(t: PageTexts, finding: Finding, target: ObjectType) -> str:
    """Return what is wrong, and what was expected, in the page's language."""
    words = ", ".join(f"“{word}”" for word in finding.words)
    key = TERM_REASONS.get(finding.term, finding.check)
    return t(f"collect_write_checks.{key}", words=words, expected=_expected(t, finding, target))


def _expected(t: PageTexts, finding: Finding, target: ObjectType) -> str:
    if finding.check == "no_target":
        return object_name(t, target)
    if finding.check == "not_there":
        return t.named("things", finding.expected).partition("|")[0]
    return finding.expected


def _utf16_length(text: str) -> int:
    return len(text.encode("utf-16-le")) // 2
