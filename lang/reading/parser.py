"""Reader of instructions: matches the language's patterns against a text and skips what it does not understand."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from arramon_client.world import PHASES
from arramon_lang.grammar import Grammar, Table
from arramon_lang.lexicon import FUZZY_LENGTH, keys_of, within_one_edit
from arramon_lang.meaning import Meaning
from arramon_lang.patterns import Alternatives, Pattern, Slot
from arramon_lang.patterns import Sequence as Body
from arramon_lang.reading.chunks import postpositions, prepositions
from arramon_lang.reading.chunks.chunker import Chunker
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import BARE, Discourse, ParsedPart
from arramon_lang.reading.itinerary import read_navigation
from arramon_lang.reading.matching import OPTIONAL, Automaton, PatternLabel, Phrasebook
from arramon_lang.reading.noun_phrases import NounPhraseParser
from arramon_lang.reading.outline import OutlineEntry, entries_of
from arramon_lang.reading.segmentation import TextSegmenter
from arramon_lang.tokens import Tokenizer

ONLY_READ_CLAUSES = (
    *("turn with", "short of", "all sides", "walk past crossed", "walk past zebra_crossing"),
    *("target", "landmark", "not target", "detail"),
)
"""Keys of clauses in navigation that are only read: of a turn and a walk along something, of a place shortly before
something, of the side of all that was passed last, of a walk over what is not named or is a crossing; of a thing that
is passed, what is not to be picked up, and what describes the thing before it."""

_Listed = Mapping[str, tuple[Pattern, ...]]


class CannotRead(ValueError):
    """Nothing in the text is understood; the message says what was expected."""


class InstructionParser:
    """Reads one language's instructions.

    Args:
        grammar: of the language.
        lexicon: the content of its `lexicon.toml`.
        relations: the content of its `relations.toml`, whose phrases are recognised too.
        tokenizer: of the language.
        chunks: the content of its `chunks.toml`, by which texts are read that its own phrases do not cover; None if the
            language has none, so that those texts are read by phrases too, as far as they go.
    """

    def __init__(
        self,
        grammar: Grammar,
        lexicon: Mapping[str, Any],
        relations: Mapping[str, Any],
        tokenizer: Tokenizer,
        chunks: Mapping[str, Any] | None = None,
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
        relations_of = {key.partition(" ")[0] for key in grammar.where}
        self.relations = self._automaton(
            grammar.where, {key: also[key] for key in also if key.partition(" ")[0] in relations_of}
        )
        for relation, phrases in relations["phrases"].items():
            for phrase in set(phrases) - set(relations.get("by_themselves", [])):
                self.relations.add_body(
                    PatternLabel(relation, only_read=True), _phrase_body(relation, phrase, relations)
                )
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
        self._long = [word for word in self._vocabulary if len(word) >= FUZZY_LENGTH]
        self._folded = self._spelt_alike()
        self._never_fuzzy = frozenset(word.casefold() for word in lexicon["not_misspelt"])
        self._corrected: dict[str, str] = {}
        self._excluded: dict[str | None, frozenset[str]] = {}

    def split(self, text: str) -> tuple[str, ...]:
        """Return the comparison keys of a text."""
        return keys_of(self._tokenizer.split(text))

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of a text, as far as it is understood.

        A text is read by the patterns that are written, if they cover all of it. So what is read of free texts can be
        understood widely, by chunks or by all patterns, and takes nothing from what is written.

        Args:
            text: the instruction.
            phase: "navigation" or "assembly".

        Raises:
            ValueError: if the phase is another.
            CannotRead: if no part of it is understood.
        """
        if phase not in PHASES:
            raise ValueError(f"phase {phase!r}; expected {' or '.join(PHASES)}")
        items, meaning, is_written = self._parse_parts(text, phase)
        if meaning is not None:
            return meaning
        if not items:
            expected = "what to pick up" if phase == "navigation" else "where to place what"
            raise CannotRead(f"nothing understood in {text[:80]!r}; expected steps or {expected}")
        discourse = Discourse(self._grammar)
        if phase == "navigation":
            return read_navigation(discourse, items)
        return discourse.assembly(items, is_written=is_written)

    def outline(self, text: str) -> tuple[OutlineEntry, ...]:
        """Return the turns of a navigation instruction and the things that it mentions, in order; `outline` says how.

        Nothing is raised for a text of which nothing is understood: its outline is empty.
        """
        keys = self._keys(text)
        discourse = Discourse(self._grammar)
        said: list[OutlineEntry] = []
        words, at = TextSegmenter(self, keys, "navigation"), 0
        for start, item in words.items():
            parts = [each for part in discourse.meanings_of(item) for each in entries_of(part)]
            known_words = {each.thing.kind for each in parts if each.thing is not None}
            passing = [*words.names(at, start, set()), *words.names(start, item.end, known_words)]
            said += [*(OutlineEntry(thing=discourse.mention(named), manner="seen") for named in passing), *parts]
            at = item.end
        rest = words.names(at, len(keys), set())
        return (*said, *(OutlineEntry(thing=discourse.mention(named), manner="seen") for named in rest))

    def excluded_slots(self, key: str | None) -> frozenset[str]:
        """Return the slots of words and tables that no text fills from this word on; None for the text's end."""
        if key not in self._excluded:
            self._excluded[key] = frozenset(slot for slot, book in self.books.items() if not book.may_begin(key))
        return self._excluded[key]

    def _parse_parts(self, text: str, phase: str) -> tuple[list[ParsedPart], Meaning | None, bool]:
        """Return a text's parts by the written patterns if they cover it, or else by all; or its chunks' meaning.

        The last value says whether the written patterns cover it.
        """
        keys = self._keys(text)
        written = TextSegmenter(self, keys, phase, written_only=True)
        parts = written.items()
        is_written = written.is_covered_by(parts)
        if not is_written:
            keys = self._without_asides(self._keys(text, self._grammar.free_reading))
            meaning = self._read_chunks(keys, phase)
            if meaning is not None:
                return [], meaning, False
            parts = TextSegmenter(self, keys, phase).items()
        return [item for _, item in parts], None, is_written

    def _read_chunks(self, keys: Sequence[str], phase: str) -> Meaning | None:
        """Return the meaning of a text by its chunks, or None if the language has none or they say too little."""
        if self.chunker is None or (phase == "assembly" and self.chunker.has_prepositions):
            return None
        text = ChunkSequence(self.chunker.chunks(keys), self.noun_phrase_parser, self.chunker.rules)
        if phase == "assembly":
            return postpositions.PlacementParser(text=text, grammar=self._grammar).read()
        reader = (
            prepositions.PrepositionRouteParser
            if self.chunker.has_prepositions
            else postpositions.PostpositionRouteParser
        )
        return reader(text=text, grammar=self._grammar).read()

    def _without_asides(self, keys: tuple[str, ...]) -> tuple[str, ...]:
        """Return a text's words without those that only say how sure or how friendly the writer is."""
        kept: list[str] = []
        at = 0
        while at < len(keys):
            end = next((end for end, _ in self._asides.at(keys, at)), at)
            kept += keys[at : at + 1] if end == at else ()
            at = max(end, at + 1)
        return tuple(kept)

    def _keys(self, text: str, rules: Iterable[tuple[str, str]] = ()) -> tuple[str, ...]:
        """Return a text's words for comparison, with typing errors corrected.

        Args:
            text: as it is given.
            rules: further regular expressions and what takes the place of what they find.
        """
        for pattern, replacement in (*self._grammar.reading, *rules):
            text = re.sub(pattern, replacement, text)
        return tuple(map(self._correct, self.split(self._tokenizer.normalise(text))))

    def _correct(self, key: str) -> str:
        """Return the word, corrected if one known word alone is spelt alike, or is within one typing error."""
        if key in self._vocabulary or key in self._never_fuzzy:
            return key
        alike = self._folded.get(self._fold(key))
        if alike is not None:
            return alike
        if len(key) < FUZZY_LENGTH:
            return key
        if key not in self._corrected:
            near = [word for word in self._long if within_one_edit(key, word)]
            if len(near) > 1:  # The first letter is seldom wrong.
                near = [word for word in near if word[0] == key[0]]
            self._corrected[key] = near[0] if len(near) == 1 else key
        return self._corrected[key]

    def _fold(self, word: str) -> str:
        """Return a word without the differences of spelling that people do not keep to."""
        for one, other in self._grammar.folding:
            word = word.replace(one, other)
        return word

    def _spelt_alike(self) -> dict[str, str]:
        """Return, for each folded spelling that only one known word has, that word."""
        found: dict[str, str] = {}
        if self._grammar.folding:
            folded = [(self._fold(word), word) for word in self._vocabulary]
            counts = Counter(spelling for spelling, _ in folded)
            found = {spelling: word for spelling, word in folded if counts[spelling] == 1}
        return found

    def _books(self) -> dict[str, Phrasebook]:
        """Return, for each word and table slot, its possible forms."""
        books = {name: Phrasebook() for name in (*self._grammar.words, *self._grammar.tables)}
        for name, forms in self._grammar.word_forms().items():
            for form in forms:
                books[name].add(self.split(form), None)
        for slot, table in self._grammar.tables.items():
            for value, patterns in table.values.items():
                for text in sorted({text for pattern in patterns for text in self._grammar.spellings(pattern)}):
                    books[slot].add(self.split(text), value)
        return books

    def _automaton(self, listed: _Listed, only_read: _Listed) -> Automaton:
        automaton = Automaton(self.split)
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
        """Return words that join clauses without a meaning of their own, and punctuation."""
        joins = Automaton(self.split)
        for patterns in self._grammar.joins.values():
            joins.add("", patterns)
        # "Right" opens sentences ("right after that, ..."), but by itself it is a turn.
        return (frozenset(joins.vocabulary) - self.turns) | OPTIONAL

    def _only_words(self, table: Table) -> Iterable[str]:
        """Yield the keys of a table's wordings that have only one."""
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


def _phrase_body(relation: str, phrase: str, relations: Mapping[str, Any]) -> Body:
    """Return the pattern of a phrase of `relations.toml`, with its landmark after or before it."""
    landmark: Body = (Alternatives(((Slot("thing"),), (Slot("joined"),))),)
    if relation == "between":
        two: Body = (Slot("thing"), f" {relations['conjunctions'][0]} ", Slot("other"))
        landmark = (Alternatives((two, (Slot("pair"),), (Slot("joined"),))),)
    return (f"{phrase} ", *landmark) if relations["position"] == "before" else (*landmark, f" {phrase}")
