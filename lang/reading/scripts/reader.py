"""Reader of texts in a second script, of texts with foreign words, and of texts whose clauses are of two languages."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from arramon_lang.coreference import map_mentions
from arramon_lang.meaning import Assembly, Meaning, Navigation, Step, Thing, Where
from arramon_lang.reading.outline import OutlineEntry
from arramon_lang.reading.parser import CannotRead, InstructionParser
from arramon_lang.reading.scripts.runs import Run, find_runs
from arramon_lang.reading.scripts.transcriber import Transcriber

MIN_OWN_WORDS = 2
"""Minimum number of different words of the language itself, in Latin letters, in a text of the language."""


class SecondScriptReader:
    """Reader of one language that also understands words and clauses of another.

    Texts without a foreign word are read by the language's own parser alone.

    Args:
        parser: the language's own parser; it learns the other language's nouns and adjectives.
        data: content of the language's `latin.toml`.
        other: parser of the language from which words and clauses are borrowed.
    """

    def __init__(self, parser: InstructionParser, data: Mapping[str, Any], other: InstructionParser) -> None:
        self._parser, self._other = parser, other
        own = frozenset(parser.vocabulary)
        self._transcriber = Transcriber(
            data,
            own,
            parser.written_words,
            parser.phrases(),
            parser.noun_phrase_parser,
            other.noun_phrase_parser,
            other.expand,
        )
        parser.noun_phrase_parser.borrow(other.noun_phrase_parser)
        self._completions: Mapping[str, Sequence[str]] = data["completions"]
        self._conjunctions = frozenset(data["conjunctions"])

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of a text, as `InstructionParser.read` does."""
        keys = self._parser.split(self._parser.unify_variants(text))
        if not self._transcriber.is_needed(keys):
            return self._parser.read(text, phase)
        runs = find_runs(keys, self._transcriber, self._other.vocabulary, self._conjunctions)
        if len(runs) == 1:
            return self._read_run(runs[0], phase)
        meanings = [meaning for number, run in enumerate(runs) for meaning in self._meanings(run, phase, number)]
        if not meanings:
            raise CannotRead(f"nothing understood in {text[:80]!r}")
        return joined(meanings)

    def count_words(self, text: str) -> int:
        """Return the number of words that texts in the second script understand; 0 for texts of the other language.

        A text is the language's if a clause of it has words that only this language has; clauses of the other language
        may stand beside it.
        """
        keys = self._parser.split(self._parser.unify_variants(text))
        runs = find_runs(keys, self._transcriber, self._other.vocabulary, self._conjunctions)
        own = {key for run in runs if not run.is_foreign for key in run.keys if self._transcriber.is_own(key)}
        if len(own - self._other.vocabulary) < MIN_OWN_WORDS:
            return 0
        words = [(key, run.is_foreign) for run in runs for key in run.keys if key[0].isalpha()]
        return sum(key in self._other.vocabulary if foreign else self._is_understood(key) for key, foreign in words)

    def _is_understood(self, key: str) -> bool:
        return self._transcriber.is_understood(key) or key in self._parser.vocabulary

    def transcribe(self, text: str) -> str:
        """Return a text in which words in Latin letters are the language's own or, if borrowed, as they are."""
        return self._transcriber.transcribe(self._parser.split(self._parser.unify_variants(text)))

    def outline(self, text: str) -> tuple[OutlineEntry, ...]:
        """Return the turns and mentioned things of a navigation text, as `InstructionParser.outline` does."""
        keys = self._parser.split(self._parser.unify_variants(text))
        if self._transcriber.is_needed(keys):
            text = self._transcriber.transcribe(keys)
        return self._parser.outline(text)

    def _read_run(self, run: Run, phase: str, completion: str = "") -> Meaning:
        if run.is_foreign:
            return self._other.read(" ".join((*run.keys, completion)), phase)
        return self._parser.read(f"{self._transcriber.transcribe(run.keys)} {completion}", phase)

    def _meanings(self, run: Run, phase: str, number: int) -> Sequence[Meaning]:
        """Return the meaning of one run of a text, or nothing if it has none.

        A run that names no target is read with one, as the languages' parsers expect, and returned without it.
        """
        try:
            meaning = self._read_run(run, phase)
        except CannotRead:
            meaning = None
        if phase == "navigation" and (meaning is None or not _target(meaning).kind):
            meaning = self._completed(run, meaning)
        return () if meaning is None else (map_mentions(meaning, lambda thing: _renamed(thing, number)),)

    def _completed(self, run: Run, meaning: Meaning | None) -> Meaning | None:
        """Return the meaning of a run that names no target."""
        continued, further = self._completions["foreign" if run.is_foreign else "own"]
        for completion, is_place in ((continued, True), (further, False)):
            try:
                completed = self._read_run(run, "navigation", completion)
            except CannotRead:
                continue
            if isinstance(completed, Navigation) and not is_place:
                return Navigation(completed.steps, _target(meaning) if meaning is not None else Thing(""))
            if isinstance(completed, Navigation) and completed.target.where and not completed.steps:
                return Navigation((), Thing("", where=completed.target.where))
        return meaning


def _target(meaning: Meaning) -> Thing:
    return meaning.target if isinstance(meaning, Navigation) else meaning.thing


@dataclass(frozen=True, slots=True)
class _Parts:
    """What several runs say: steps or turns, the object, and its relations."""

    steps: tuple[Step, ...] = ()
    turns: tuple[str, ...] = ()
    thing: Thing = field(default_factory=lambda: Thing(""))
    where: tuple[Where, ...] = ()


def joined(meanings: Sequence[Meaning]) -> Meaning:
    """Return the meaning of a text from the meanings of its runs, in order."""
    parts = _Parts()
    for meaning in meanings:
        said = meaning.target if isinstance(meaning, Navigation) else meaning.thing
        where = said.where if isinstance(meaning, Navigation) else meaning.where
        is_new = not parts.thing.kind and (said.kind or said.colour or said.look)
        parts = replace(
            parts,
            steps=parts.steps + (meaning.steps if isinstance(meaning, Navigation) else ()),
            turns=parts.turns + (meaning.turns if isinstance(meaning, Assembly) else ()),
            thing=said if is_new else parts.thing,
            where=tuple(dict.fromkeys((*parts.where, *where))),
        )
    if isinstance(meanings[0], Navigation):
        return Navigation(parts.steps, replace(parts.thing, where=parts.where))
    return Assembly(parts.turns, parts.thing, parts.where)


def _renamed(thing: Thing, number: int) -> Thing:
    """Return a thing whose identity differs from those of other runs, each of which counts its own things."""
    return replace(thing, identity=f"{number}.{thing.identity}") if thing.identity else thing
