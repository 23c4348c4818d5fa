"""Whether a text names a kind of thing by one of its exact names, of which no other kind has the same."""

from collections import Counter
from functools import cache
from pathlib import Path

from arramon_lang.language import ROOT, load

Words = tuple[str, ...]


def names_exactly(text: str, kind: str, language: str, root: Path = ROOT) -> bool:
    """Return whether a text has an exact name of a kind, word by word.

    Readers of free texts also guess: at misspelt words, and at words that several kinds share. That is no match here.

    Args:
        text: the text.
        kind: a kind of `things.toml`.
        language: code of the text's language, which has a grammar.
        root: folder that contains the languages' folders.
    """
    words = _words(text, language, root)
    return any(
        words[start : start + len(name)] == name
        for name in _names(language, root).get(kind, ())
        for start in range(len(words) - len(name) + 1)
    )


@cache
def _names(language: str, root: Path) -> dict[str, frozenset[Words]]:
    """Return the names that only one kind has, by kind."""
    grammar = load(language, root).grammar
    names = {
        kind: {_words(form, language, root) for lexeme in lexemes if lexeme.weight for _, form in lexeme.forms}
        for kind, lexemes in grammar.nouns.items()
    }
    others = {kind: {_words(name, language, root) for name in listed} for kind, listed in grammar.also_nouns.items()}
    kinds = Counter(
        name for kind in names.keys() | others.keys() for name in names.get(kind, set()) | others.get(kind, set())
    )
    return {kind: frozenset(name for name in listed if kinds[name] == 1) for kind, listed in names.items()}


def _words(text: str, language: str, root: Path) -> Words:
    spoken = load(language, root)
    return tuple(word.casefold() for word in spoken.tokenize(text.replace("~", "")))
