"""Parser of instructions: matches a language's patterns against a text, and skips parts that it does not understand."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from arramon_client.world import PHASES
from arramon_lang.files import BARE, ONLY_READ_CLAUSES
from arramon_lang.grammar import Grammar, Table
from arramon_lang.lexicon import keys_of
from arramon_lang.meaning import Meaning
from arramon_lang.patterns import Pattern, Slot
from arramon_lang.reading.chunks.chunker import Chunker
from arramon_lang.reading.chunks.parsers import parser_for
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import Discourse
from arramon_lang.reading.itinerary import read_navigation
from arramon_lang.reading.matching import OPTIONAL, Automaton, PatternLabel, Phrasebook, with_and_without
from arramon_lang.reading.noun_phrases import NounPhraseParser
from arramon_lang.reading.outline import OutlineEntry, entries_of
from arramon_lang.reading.relation_patterns import relation_automaton
from arramon_lang.reading.segmentation import TextSegmenter
from arramon_lang.reading.spelling import SpellingCorrector
from arramon_lang.reading.typing_errors import TypingCorrector
from arramon_lang.tokens import ScriptTokenizer

_Listed = Mapping[str, tuple[Pattern, ...]]


class CannotRead(ValueError):
    """No part of the text was understood; the message says what was expected."""


class InstructionParser:
    """Parser of one language's instructions.

    Args:
        grammar: the language's grammar.
        lexicon: content of its `lexicon.toml`.
        relations: content of its `relations.toml`, whose phrases are recognised too.
        tokenizer: the language's tokenizer.
        chunks: content of its `chunks.toml`, for texts that the written phrases do not cover; None to parse those
            texts by phrases alone.
        typing: content of its `typing.toml`, to correct typing errors; None to correct single long words alone.
    """

    def __init__(
        self,
        grammar: Grammar,
        lexicon: Mapping[str, Any],
        relations: Mapping[str, Any],
        tokenizer: ScriptTokenizer,
        chunks: Mapping[str, Any] | None = None,
        typing: Mapping[str, Any] | None = None,
    ) -> None:
        self._grammar = grammar
        self._tokenizer = tokenizer
        self.conjunctions = frozenset(relations["conjunctions"])
        self.noun_phrase_parser = NounPhraseParser(grammar, lexicon, self.split, self.conjunctions)
        self.books = self._books()
        also = grammar.also_read
        nested = {key: also[key] for key in also if key == "nested"}
        targets = {f"target {key}": patterns for key, patterns in grammar.target.items()}
        self.clauses = {
            "navigation": self._automaton(
                {**grammar.steps, **targets},
                {key: also[key] for key in also if key.removesuffix(BARE) in (*grammar.steps, *ONLY_READ_CLAUSES)},
            ),
            "assembly": self._automaton(grammar.assembly, {key: also[key] for key in also if key in grammar.assembly}),
        }
        self.attached = self._automaton({"attached": grammar.attached, "nested": grammar.nested}, nested)
        self.nested = self._automaton({"nested": grammar.nested}, nested)
        self.relations = relation_automaton(grammar, relations, self.split)
        self.joins = {
            True: self._joins(("where", "where of more", "where after clause")),
            False: self._joins(("nested where",)),
        }
        self.exact_slots = frozenset(slot for slot, table in grammar.tables.items() if table.attribute == "exactly")
        tables = [table for table in grammar.tables.values() if table.attribute == "direction"]
        self.turns = frozenset(key for table in tables for key in self._only_words(table))
        self.fillers = self._fillers()
        self.openers = frozenset(key for word in grammar.openers for key in self.split(word)) | OPTIONAL
        self.chunker = None
        if chunks is not None:
            self.chunker = Chunker(chunks, self.noun_phrase_parser, self.conjunctions, self.split)
        self._asides = Phrasebook()
        for phrase in grammar.asides:
            self._asides.add(self.split(phrase), None)
        self._vocabulary = frozenset(self._all_words())
        self.noun_phrase_parser.known_words = self._vocabulary
        never_fuzzy = frozenset(word.casefold() for word in lexicon["not_misspelt"])
        self._spelling = SpellingCorrector(self._vocabulary, grammar.folding, never_fuzzy, self._is_compound)
        self._typing = None
        if typing is not None:
            naming = self.noun_phrase_parser.vocabulary
            self._typing = TypingCorrector(self._vocabulary | never_fuzzy, naming, typing)
            self._rewriting = [
                (re.compile(rule["pattern"]), rule["words"], rule["phases"]) for rule in typing["rewriting"]
            ]
        self._excluded: dict[str | None, frozenset[str]] = {}

    @property
    def vocabulary(self) -> frozenset[str]:
        """All words that the parser understands."""
        return self._vocabulary

    @property
    def written_words(self) -> frozenset[str]:
        """Words of texts that the grammar writes: inflected words, nouns and adjectives."""
        forms = (form for forms in self._grammar.word_forms().values() for form in forms)
        nouns = (form for lexemes in self._grammar.nouns.values() for lexeme in lexemes for _, form in lexeme.forms)
        tables = (
            text
            for table in self._grammar.tables.values()
            for patterns in table.values.values()
            for pattern in patterns
            if pattern.weight
            for text in self._grammar.spellings(pattern)
        )
        return frozenset(word for text in (*forms, *nouns, *tables) for word in self.split(text))

    def phrases(self) -> Iterator[tuple[str, ...]]:
        """Yield fixed phrases of the language, whose words stand beside each other in texts."""
        yield from self.noun_phrase_parser.phrases()
        if self.chunker is not None:
            yield from self.chunker.phrases()

    def split(self, text: str) -> tuple[str, ...]:
        """Return the comparison keys of a text."""
        return keys_of(self._tokenizer.split(text))

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of a text, as far as it is understood.

        If the written patterns cover the whole text, they alone determine its meaning. Otherwise it is parsed by
        chunks, and without a result by all patterns; so rules for free texts cannot change the meaning of written ones.

        Args:
            text: the instruction.
            phase: "navigation" or "assembly".

        Raises:
            ValueError: if the phase is unknown.
            CannotRead: if no part of the text is understood.
        """
        if phase not in PHASES:
            raise ValueError(f"phase {phase!r}; expected {' or '.join(PHASES)}")
        written = TextSegmenter(self, self._keys(text), phase, written_only=True)
        parts = written.items()
        is_written = written.is_covered_by(parts)
        if not is_written:
            keys = self._without_asides(self._keys(self._unabbreviated(text, phase), self._grammar.free_reading))
            meaning = self._read_chunks(keys, phase)
            if meaning is not None:
                return meaning
            parts = TextSegmenter(self, keys, phase).items()
        if not parts:
            expected = "what to pick up" if phase == "navigation" else "where to place what"
            raise CannotRead(f"nothing understood in {text[:80]!r}; expected steps or {expected}")
        discourse, items = Discourse(self._grammar), [item for _, item in parts]
        if phase == "navigation":
            return read_navigation(discourse, items)
        return discourse.assembly(items, is_written=is_written)

    def reads_whole(self, text: str, phase: str) -> bool:
        """Return whether `read` skips no word of a text that matters, so that its meaning can be relied on.

        Texts that are read by chunks never count as whole.

        Args:
            text, phase: as for `read`.
        """
        written = TextSegmenter(self, self._keys(text), phase, written_only=True)
        if written.is_covered_by(written.items()):
            return True
        if self.chunker is not None and parser_for(self.chunker.rules, phase) is not None:
            return False
        keys = self._without_asides(self._keys(self._unabbreviated(text, phase), self._grammar.free_reading))
        words = TextSegmenter(self, keys, phase)
        return words.is_covered_by(words.items())

    def outline(self, text: str) -> tuple[OutlineEntry, ...]:
        """Return the turns and mentioned things of a navigation instruction, in order.

        The outline is empty if no part of the text is understood.
        """
        keys = self._keys(text)
        discourse = Discourse(self._grammar)
        entries: list[OutlineEntry] = []
        words, at = TextSegmenter(self, keys, "navigation"), 0
        for start, item in words.items():
            parts = [each for part in discourse.meanings_of(item) for each in entries_of(part)]
            known_kinds = {each.thing.kind for each in parts if each.thing is not None}
            passing = [*words.unparsed_things(at, start, set()), *words.unparsed_things(start, item.end, known_kinds)]
            entries += [*(OutlineEntry(thing=discourse.mention(named), manner="seen") for named in passing), *parts]
            at = item.end
        rest = words.unparsed_things(at, len(keys), set())
        return (*entries, *(OutlineEntry(thing=discourse.mention(named), manner="seen") for named in rest))

    def excluded_slots(self, key: str | None) -> frozenset[str]:
        """Return the slots that no phrase beginning with this word can fill; None for the end of the text."""
        if key not in self._excluded:
            self._excluded[key] = frozenset(slot for slot, book in self.books.items() if not book.may_begin(key))
        return self._excluded[key]

    def _read_chunks(self, keys: Sequence[str], phase: str) -> Meaning | None:
        """Return the meaning of a text by its chunks, or None if the language has none or they do not suffice."""
        parser = None if self.chunker is None else parser_for(self.chunker.rules, phase)
        if self.chunker is None or parser is None:
            return None
        text = ChunkSequence(self.chunker.chunks(keys), self.noun_phrase_parser, self.chunker.rules)
        return parser(text=text, grammar=self._grammar).read()

    def _without_asides(self, keys: tuple[str, ...]) -> tuple[str, ...]:
        """Return a text's words without hedges and courtesies ("I think", "please")."""
        kept: list[str] = []
        at = 0
        while at < len(keys):
            end = next((end for end, _ in self._asides.at(keys, at)), at)
            kept += keys[at : at + 1] if end == at else ()
            at = max(end, at + 1)
        return tuple(kept)

    def _keys(self, text: str, rules: Iterable[tuple[str, str]] = ()) -> tuple[str, ...]:
        """Return a text's comparison keys, with typing errors corrected.

        Args:
            text: the original text.
            rules: additional (regular expression, replacement) pairs.
        """
        for pattern, replacement in (*self._grammar.reading, *rules):
            text = re.sub(pattern, replacement, text)
        keys = tuple(map(self.correct, self.split(self._tokenizer.normalise(text))))
        return keys if self._typing is None else self._typing.correct(keys)

    def _unabbreviated(self, text: str, phase: str) -> str:
        """Return a text with what terse notes leave out."""
        for pattern, words, phases in () if self._typing is None else self._rewriting:
            if phase in phases:
                text = pattern.sub(words, text)
        return text

    def unify_variants(self, text: str) -> str:
        """Return a text with the language's variant spellings and wordings unified."""
        for pattern, replacement in self._grammar.reading:
            text = re.sub(pattern, replacement, text)
        return text

    def correct(self, key: str) -> str:
        """Return the word, or the only known word with the same folded spelling or within one typing error."""
        return self._spelling.correct(key)

    def _is_compound(self, key: str) -> bool:
        return self.chunker is not None and bool(self.chunker.split_suffix(key))

    def expand(self, key: str) -> tuple[str, ...]:
        """Return the words that one stands for: without typing errors, and written in full."""
        corrected = self.correct(key)
        return (corrected,) if self._typing is None else self._typing.words(corrected)

    def _books(self) -> dict[str, Phrasebook]:
        """Return a phrasebook of all possible texts for each word and table slot."""
        books = {name: Phrasebook() for name in (*self._grammar.words, *self._grammar.tables)}
        for name, forms in self._grammar.word_forms().items():
            for form in filter(None, forms):
                for keys in with_and_without(self.split(form), self._grammar.articles):
                    books[name].add(keys, None)
        for slot, table in self._grammar.tables.items():
            for value, patterns in table.values.items():
                for text in sorted({text for pattern in patterns for text in self._grammar.spellings(pattern)}):
                    for keys in with_and_without(self.split(text), self._grammar.articles):
                        books[slot].add(keys, value)
        return books

    def _automaton(self, listed: _Listed, only_read: _Listed) -> Automaton:
        automaton = Automaton(self.split, self._grammar.articles)
        for key, patterns in listed.items():
            automaton.add(key, patterns)
        for key, patterns in only_read.items():
            automaton.add(key, patterns, only_read=True)
        return automaton

    def _joins(self, names: Iterable[str]) -> Automaton:
        automaton = Automaton(self.split)
        for name in names:
            for pattern in self._grammar.joins[name]:
                automaton.add_body(
                    PatternLabel(name), tuple(part for part in pattern.body if not isinstance(part, Slot))
                )
        return automaton

    def _fillers(self) -> frozenset[str]:
        """Return words that only join clauses, and punctuation."""
        joins = Automaton(self.split)
        for patterns in self._grammar.joins.values():
            joins.add("", patterns)
        # "Right" opens sentences ("right after that, ..."), but by itself it is a turn.
        return (frozenset(joins.vocabulary) - self.turns) | OPTIONAL

    def _only_words(self, table: Table) -> Iterable[str]:
        """Yield the wordings of a table that are a single word."""
        for patterns in table.values.values():
            for text in (text for pattern in patterns for text in self._grammar.spellings(pattern)):
                if len(keys := self.split(text)) == 1:
                    yield keys[0]

    def _all_words(self) -> Iterable[str]:
        yield from self.fillers
        yield from self._asides.vocabulary
        yield from self.noun_phrase_parser.vocabulary
        yield from () if self.chunker is None else self.chunker.vocabulary
        for book in self.books.values():
            yield from book.vocabulary
        for automaton in (*self.clauses.values(), self.attached, self.nested, self.relations):
            yield from automaton.vocabulary
