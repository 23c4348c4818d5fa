"""Texts of the collections' pages: the leaderboard's, and those in `texts`, with English for missing ones."""

import os
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from arramon_server.errors import NotFound
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts, all_texts, read_texts

FOLDER = Path(__file__).parent / "texts"

FURTHER_FOLDER = "ARRAMON_COLLECT_TEXTS"
"""Environment variable that names a folder with texts of further languages, `xx.toml`."""


def texts_of(language: str) -> PageTexts:
    """Return the texts of the pages in a language.

    Raises:
        NotFound: if there is no file of that language.
    """
    found = _all(os.environ.get(FURTHER_FOLDER, "")).get(language)
    if found is None:
        there = ", ".join(one.language for one in page_languages())
        raise NotFound(
            f"the pages have no words in {language!r}, which are in the file {language}.toml of the folder that "
            f"${FURTHER_FOLDER} names; they are in {there}"
        )
    return found


def page_languages() -> list[PageTexts]:
    """Return the texts of all languages, the default language first."""
    return list(_all(os.environ.get(FURTHER_FOLDER, "")).values())


def languages_of(wanted: Sequence[str]) -> list[PageTexts]:
    """Return the texts of the languages in which a collection's pages are offered: those wanted, all if none is."""
    return [texts for texts in page_languages() if not wanted or texts.language in wanted]


def missing_texts(language: str) -> list[str]:
    """Return the keys that a language has no text for, so that the page shows them in English.

    Raises:
        NotFound: if there is no file of that language.
    """
    texts_of(language)
    needed = {**_own(DEFAULT_LANGUAGE), **all_texts()[DEFAULT_LANGUAGE].words}
    there = {**_own(language), **(all_texts()[language].words if language in all_texts() else {})}
    return sorted(needed.keys() - there.keys())


def _own(language: str) -> Mapping[str, object]:
    """Return the collections' own texts in a language."""
    folders = [FOLDER, *(Path(each) for each in (os.environ.get(FURTHER_FOLDER, ""),) if each)]
    found: dict[str, object] = {}
    for path in (folder / f"{language}.toml" for folder in folders):
        if path.is_file():
            found |= read_texts(path).words
    return found


@cache
def _all(further: str) -> dict[str, PageTexts]:
    """Return the texts of every language by code; `further` is the folder of further languages."""
    folders = [FOLDER, *([Path(further)] if further else [])]
    codes = {path.stem for folder in folders for path in folder.glob("*.toml")}
    english = {**all_texts()[DEFAULT_LANGUAGE].words, **_own(DEFAULT_LANGUAGE)}
    merged = {}
    for code in sorted(codes, key=lambda code: (code != DEFAULT_LANGUAGE, code)):
        server = all_texts()[code].words if code in all_texts() else {}
        merged[code] = PageTexts(code, {**english, **server, **_own(code)})
    return merged
