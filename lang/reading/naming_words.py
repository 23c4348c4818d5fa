"""Words that name and describe things: nouns, adjectives, determiners and pronouns of one language."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from arramon_lang.grammar import INSIDE, Grammar, Lexeme
from arramon_lang.reading.matching import Keys, Phrasebook, SplitWords, with_and_without


@dataclass(frozen=True, slots=True)
class WordSense:
    """One sense of a word or fixed phrase.

    Attributes:
        role: "noun", "look", "colour", "which", "determiner", "same", "another", "two", "several", "modifier" or
            "pronoun".
        value: a noun's kind; an adjective's value of the attribute named by `role`.
        kind: of things that an adjective describes, "" for any; PLURAL for a noun's form that is always plural.
        look: that a noun implies ("the bank").
        arms: number of streets that meet at a junction with that noun.
    """

    role: str
    value: str = ""
    kind: str = ""
    look: str = ""
    arms: int = 0


PATTERNED = "\0"
"""Placeholder kind of a noun that denotes a collectible only if a pattern is stated."""

PLURAL = "plural"
"""`WordSense.kind` of noun forms that are always plural."""

DESCRIBING = ("look", "colour", "which", "two", "several", "modifier")
"""Roles of adjectives; the first of a word's roles that suits the noun applies."""


class NamingWords:
    """One language's words of noun phrases.

    Args:
        grammar: the language's grammar.
        lexicon: content of its `lexicon.toml`, whose words for collectibles are recognised too.
        split: splits a text into comparison keys.

    Attributes:
        book: words before a noun, and nouns.
        after: adjectives that follow the noun.
        divided: beginnings of nouns with a place for adjectives inside.
        of, own: words before a corner's building ("of the"), and possessives ("its").
        patterned: kind of nouns that denote a collectible only with a pattern.
        collectibles: kinds of collectibles, and "".
    """

    def __init__(self, grammar: Grammar, lexicon: Mapping[str, Any], split: SplitWords) -> None:
        self._grammar = grammar
        self._split = split
        self.collectibles = frozenset((*lexicon["kinds"], ""))
        self._object_colours = frozenset(lexicon["colours"])
        self.book = Phrasebook()
        self.after = Phrasebook()
        self.divided = Phrasebook()
        self.of, self.own = Phrasebook(), Phrasebook()
        for book, texts in ((self.of, grammar.of), (self.own, grammar.own)):
            for text in texts:
                book.add(split(text), None)
        self.patterned = {
            split(phrase): kind for kind, phrases in lexicon["patterned_kinds"].items() for phrase in phrases
        }
        for role, value, phrases in (
            ("determiner", "", grammar.determiners), ("same", "", grammar.same), ("pronoun", "", grammar.pronouns),
            ("another", "", grammar.another), ("two", "two", grammar.two), ("several", "several", grammar.several),
            ("modifier", "", (*grammar.modifiers, *lexicon["modifiers"])),
        ):  # fmt: skip
            for phrase in phrases:
                self.book.add(split(phrase), WordSense(role, value))
        self._add_nouns(lexicon)
        self._add_adjectives(lexicon)

    @property
    def vocabulary(self) -> set[str]:
        """All words of noun phrases."""
        return self.book.vocabulary | self.after.vocabulary

    def borrow(self, other: "NamingWords") -> None:
        """Add the nouns, adjectives and determiners of another language, which texts of this one may use."""
        for own, borrowed in ((self.book, other.book), (self.after, other.after)):
            for keys, word in borrowed.entries():
                if isinstance(word, WordSense) and word.role not in ("pronoun", "same"):
                    own.add(keys, word)
        self.patterned |= other.patterned

    def describes(self, key: str) -> bool:
        """Return whether a word by itself is a colour or a look, or a noun with a look."""
        return any(
            end == 1 and (word.role in ("colour", "look") or (word.role == "noun" and bool(word.look)))
            for end, word in self.at(self.book, (key,), 0)
        )

    def _add_nouns(self, lexicon: Mapping[str, Any]) -> None:
        written = {kind: self._add_written_nouns(kind, nouns) for kind, nouns in self._grammar.nouns.items()}
        for also in (self._grammar.also_nouns, lexicon["kinds"], {"": lexicon["stand_ins"]}):
            for kind, phrases in also.items():
                for phrase in phrases:
                    if self._split(phrase) not in written.get(kind, ()):
                        self.book.add(self._split(phrase), WordSense("noun", kind))
        for kind, looks in self._grammar.also_looks.items():
            for look, phrases in looks.items():
                for phrase in phrases:
                    self.book.add(self._split(phrase), WordSense("noun", kind, look=look))
        for phrase in self.patterned:
            self.book.add(phrase, WordSense("noun", PATTERNED))

    def _add_written_nouns(self, kind: str, lexemes: Sequence[Lexeme]) -> set[Keys]:
        """Add a kind's nouns, and return their forms."""
        plural = frozenset(self._grammar.pair_marks)
        singular = {text for each in lexemes for marks, text in each.forms if not marks & plural}
        arms = {form: lexeme.arms for lexeme in lexemes for _, form in lexeme.forms}
        written: set[Keys] = set()
        for form in filter(None, arms):  # Elided ones are empty.
            number = "" if form in singular else PLURAL
            for keys in with_and_without(self._split(form.replace(INSIDE, "")), self._grammar.articles):
                self.book.add(keys, WordSense("noun", kind, number, arms=arms[form]))
                written.add(keys)
            if INSIDE in form:
                head, tail = map(self._split, form.split(INSIDE))
                for keys in with_and_without(head, self._grammar.articles):
                    self.divided.add(keys, (*keys, *tail))
        return written

    def _add_adjectives(self, lexicon: Mapping[str, Any]) -> None:
        grammar = self._grammar
        colours = (("colour", kind, listed) for kind, listed in grammar.colours_of.items())
        for role, kind, listed in (("colour", "", grammar.colours), ("which", "", grammar.whiches), *colours):
            for value, patterns in listed.items():
                for text in sorted({text for pattern in patterns for text in grammar.spellings(pattern)}):
                    self.book.add(self._split(text), WordSense(role, value, kind))
        for kind, looks in grammar.looks.items():
            for value, wordings in looks.items():
                for wording in wordings:
                    book = self.after if wording.after else self.book
                    for text in sorted(grammar.spellings(wording.wording)):
                        book.add(self._split(text), WordSense("look", value, kind))
        for value, phrases in lexicon["colours"].items():
            for phrase in phrases:
                self.book.add(self._split(phrase), WordSense("colour", value))
        for value, phrases in lexicon["patterns"].items():
            for phrase in phrases:
                self.book.add(self._split(phrase), WordSense("look", value, "collectible"))

    def nouns(self, keys: Sequence[str], at: int) -> list[tuple[int, WordSense]]:
        """Return the ends and senses of nouns that begin at `keys[at]`."""
        return [(end, word) for end, word in self.at(self.book, keys, at) if word.role == "noun"]

    def at(self, book: Phrasebook, keys: Sequence[str], at: int) -> Iterator[tuple[int, WordSense]]:
        """Yield the ends and senses of a book's words that begin at `keys[at]`."""
        for end, word in book.at(keys, at):
            if isinstance(word, WordSense):
                yield end, word

    def suits(self, word: WordSense, kind: str) -> bool:
        """Return whether an adjective can describe things of a kind."""
        if word.role == "look":
            return word.kind == self._grammar.look_kind(kind) or (
                word.kind == "collectible" and kind in self.collectibles
            )
        if word.role == "colour":
            if word.kind:
                return word.kind == kind
            return kind not in self.collectibles or word.value in self._object_colours
        return True
