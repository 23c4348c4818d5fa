"""Grammar of a language, loaded from its files: inflected words, nouns, adjectives, phrases and joins."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from typing import Any

from arramon_lang.patterns import (
    Alternatives,
    Pattern,
    Sequence,
    parse,
    possible_slots,
    required_slots,
    spell_out,
    split_weight,
    with_fragments,
)

SLOTS = frozenset(
    (
        *(
            "thing",
            "other",
            "pair",
            "several",
            "joined",
            "landmark",
            "further",
            "detail",
            "wall",
            "holder",
            "target",
            "where",
        ),
        *("noun", "which", "look", "look_after", "colour"),
        *("a", "b", "c"),
    )
)
"""Slots that are neither words nor tables. These occur only in patterns that are only read: "joined", two things that
share a noun; "landmark" and "further", things that cannot be picked up; "wall"; "holder", a thing that can be picked
up; "detail", a thing that describes the one before it."""

AFTER = "~"
"""Marks the beginning of a look that follows the noun: "~with a star"."""

INSIDE = "~"
"""Marks the place of adjectives within a noun of several words: "the end of the ~street"."""

LOOKS_AS = {"building_corner": "building"}
"""Kinds that share the looks of another kind."""

JOINS = (
    *("sentence", "assembly", "first", "later", "last"),
    *("where", "where of more", "where after clause", "nested where"),
)

FORMS_KEPT = 16384
"""Maximum number of inflected forms that are remembered."""

Features = Mapping[str, str]
"""Values of grammatical axes: {"case": "oblique", "gender": "feminine"}."""

Options = tuple[list[Sequence], list[float]]
"""Alternative sequences, and their cumulative weights."""

Patterns = tuple[Pattern, ...]
"""Wordings to choose from."""


@dataclass(frozen=True, slots=True, eq=False)
class Lexeme:
    """A word with its inflected forms.

    Attributes:
        forms: (marks, form) pairs; the first is the dictionary form.
        given: features that it imposes on agreeing words, such as its gender.
        weight: relative probability of being written; 0 if it is only read.
        arms: number of streets that meet at the intersections that it names; 0 for any.
    """

    forms: tuple[tuple[frozenset[str], str], ...]
    given: tuple[tuple[str, str], ...] = ()
    weight: float = 1.0
    arms: int = 0

    def form(self, features: Features) -> str | None:
        """Return the most specific form whose marks all hold, or None if no form fits."""
        if len(self.forms) == 1 and not self.forms[0][0]:
            return self.forms[0][1]
        return _form_with(self, tuple(features.values()))


@lru_cache(maxsize=FORMS_KEPT)
def _form_with(word: Lexeme, features: tuple[str, ...]) -> str | None:
    values = {*features, *(value for _, value in word.given)}
    fitting = [(len(marks), text) for marks, text in word.forms if marks <= values]
    return max(fitting, key=lambda each: each[0])[1] if fitting else None


@dataclass(frozen=True, slots=True)
class Table:
    """Wordings for each value of `attribute`, an attribute of `arramon_lang.meaning` ("direction")."""

    attribute: str
    values: Mapping[str, tuple[Pattern, ...]]

    def wordings_in(self, content: Mapping[str, object]) -> tuple[Pattern, ...]:
        """Return the wordings for the value that the content has for the attribute; none if it has none."""
        value = content.get(self.attribute)
        return self.values.get(value, ()) if isinstance(value, str) else ()


@dataclass(frozen=True, slots=True, eq=False)
class LookWording:
    """A wording for a thing's look; `after` if it follows the noun ("with a star")."""

    wording: Pattern
    after: bool

    @property
    def weight(self) -> float:
        """Relative probability of being written."""
        return self.wording.weight


class Grammar:
    """Parsed content of `grammar.toml`, `things.toml` and `phrases.toml`; comments in `lang/en` describe the formats.

    Attributes:
        imposed: axes whose value a noun gives to the words that agree with it, such as gender.

    Raises:
        ValueError: if an entry is missing or contains an undeclared mark, slot or word; names the entry.
    """

    def __init__(self, grammar: Mapping[str, Any], things: Mapping[str, Any], phrases: Mapping[str, Any]) -> None:
        for name, read, content in (
            ("grammar", self._read_grammar, grammar),
            ("things", self._read_things, things),
            ("phrases", self._read_phrases, phrases),
        ):
            try:
                read(content)
            except KeyError as error:
                raise ValueError(f"{name}.toml: {error} is missing; it may be empty") from error
            except ValueError as error:
                raise ValueError(f"{name}.toml: {error}") from error

    def _read_grammar(self, grammar: Mapping[str, Any]) -> None:
        self.axes: dict[str, list[str]] = dict(grammar["features"])
        self._axis_of = {value: axis for axis, values in self.axes.items() for value in values}
        text = grammar["text"]
        self.per_episode: dict[str, dict[str, float]] = text["per_episode"]
        for axis, values in self.per_episode.items():
            if axis not in self.axes or not values.keys() <= set(self.axes[axis]):
                raise ValueError(f"text.per_episode: {axis} is not an axis with the values {', '.join(values)}")
        self.sentence_end: str = text["sentence_end"]
        self.spelling = [(re.compile(rule[0]), str(rule[1])) for rule in text["spelling"]]
        self.reading: list[tuple[str, str]] = [(rule[0], rule[1]) for rule in text["reading"]]
        self.free_reading: list[tuple[str, str]] = [(rule[0], rule[1]) for rule in text.get("free_reading", [])]
        self.folding: list[tuple[str, str]] = [(rule[0], rule[1]) for rule in text.get("folding", [])]
        self.openers: list[str] = text.get("openers", [])
        owners = text.get("owners", {})
        self.of: list[str] = owners.get("of", [])
        self.own: list[str] = owners.get("own", [])
        self.asides: list[str] = text.get("asides", [])
        self.clumsy = [re.compile(pattern) for pattern in text.get("clumsy", [])]
        self.straight: str = text.get("straight", "")
        self.first_mention: frozenset[str] = frozenset(text.get("first_mention", []))
        self.ends: dict[str, float] = text.get("ends", {self.sentence_end: 1.0})
        self.evenness: float = text.get("evenness", 1.0)
        self.small_letters: float = text.get("small_letters", 0.0)
        articles = text.get("articles", {"words": [], "left_out": 0.0})
        self.articles: frozenset[str] = frozenset(articles["words"])
        self.articles_left_out: float = articles["left_out"]
        self.favourites: list[list[str]] = text.get("favourites", [])
        self._classes = grammar.get("classes", {})
        self.words = {name: self._lexemes(f"words.{name}", entry) for name, entry in grammar["words"].items()}
        self._slots: frozenset[str] = frozenset(self.words)
        self._introduced: dict[int, tuple[Sequence, frozenset[str]]] = {}
        self._slots_of: dict[int, tuple[Sequence, tuple[frozenset[str], frozenset[str]]]] = {}
        self._options: dict[tuple[int, frozenset[str]], tuple[Alternatives, Options]] = {}
        self._fitting: dict[tuple[int, frozenset[str], frozenset[str]], tuple[Patterns, Patterns]] = {}
        self._worded: dict[tuple[int, tuple[tuple[str, str], ...]], tuple[Sequence, bool]] = {}
        self.tables = {
            slot: Table(table["of"], self._tabled(f"tables.{slot}", table["values"]))
            for slot, table in grammar["tables"].items()
        }

    def _read_things(self, things: Mapping[str, Any]) -> None:
        self.nouns = {kind: self._lexemes(f"nouns.{kind}", entries) for kind, entries in things["nouns"].items()}
        self.imposed = {axis for nouns in self.nouns.values() for noun in nouns for axis, _ in noun.given}
        self.also_nouns: dict[str, list[str]] = things["also_read"]
        self.also_looks: dict[str, dict[str, list[str]]] = things.get("also_read_looks", {})
        self.colours = self._adjectives("colours", things["colours"])
        self.colours_of = {
            kind: self._adjectives(f"colours_of.{kind}", listed)
            for kind, listed in things.get("colours_of", {}).items()
        }
        self.whiches = self._adjectives("whiches", things["whiches"])
        self.looks = {
            kind: {value: self._wordings(f"looks.{kind}.{value}", texts) for value, texts in looks.items()}
            for kind, looks in things["looks"].items()
        }
        self._slots |= SLOTS | self.tables.keys()
        self.noun_phrases = self._patterns("noun_phrases", things["noun_phrases"])
        self.pair_phrases = self._patterns("pair_phrases", things["pair_phrases"])
        self.pair_marks: list[str] = things["pair_marks"]
        self.several_phrases = self._patterns("several_phrases", things["several_phrases"])
        self.another_phrases = self._patterns("another_phrases", things["another_phrases"])
        self.same_phrases = self._patterns("same_phrases", things["same_phrases"])
        self._phrases_of = {
            name: self._tabled(name, things.get(name, {}))
            for name in (f"{each}_phrases_of" for each in ("noun", "pair", "several", "same", "another"))
        }
        self.attached = self._patterns("attached", things["attached"])
        self.nested = self._patterns("nested", things["nested"])
        self.determiners: list[str] = things["determiners"]
        self.same: list[str] = things["same"]
        self.another: list[str] = things["another"]
        self.two: list[str] = things["two"]
        self.several: list[str] = things["several"]
        self.pronouns: list[str] = things["pronouns"]
        self.modifiers: list[str] = things["modifiers"]

    def _read_phrases(self, phrases: Mapping[str, Any]) -> None:
        self.steps = self._tabled("steps", phrases["steps"])
        self.where = self._tabled("where", phrases["where"])
        self.target = self._tabled("target", phrases["target"])
        self.assembly = self._tabled("assembly", phrases["assembly"])
        self.joins = self._tabled("joins", phrases["joins"])
        also_read = {
            key: [with_fragments(text, phrases.get("fragments", {})) for text in texts]
            for key, texts in phrases["also_read"].items()
        }
        self.also_read = self._tabled("also_read", also_read)
        for name, table, keys in (
            ("target", self.target, ("clause", "sentences", "same")),
            ("assembly", self.assembly, ("turn", "place", "place it")),
            ("joins", self.joins, JOINS),
        ):
            missing = [key for key in keys if key not in table]
            if missing:
                raise ValueError(f"{name}: {', '.join(missing)} missing")
        if "purpose" in self.joins and "purpose" not in self.target:
            raise ValueError("target: purpose missing, which joins have")

    def features_of(self, marks: Iterable[str]) -> dict[str, str]:
        """Return the marks by axis.

        Raises:
            ValueError: if a mark is not a value of any feature.
        """
        marks = tuple(marks)
        for mark in marks:
            if mark not in self._axis_of:
                raise ValueError(f"{mark!r} is not a value of a feature; expected one of {', '.join(self._axis_of)}")
        return {self._axis_of[mark]: mark for mark in marks}

    def slots_of(self, body: Sequence) -> tuple[frozenset[str], frozenset[str]]:
        """Return the slots that every variant of one of the grammar's sequences contains, and those that some do."""
        known = self._slots_of.get(id(body))
        if known is None:
            fillable = SLOTS | self.tables.keys()
            known = self._slots_of[id(body)] = (
                body,  # Kept, so that its id stays its own.
                (required_slots(body, fillable), possible_slots(body, fillable)),
            )
        return known[1]

    def fullest_options(self, choice: Alternatives, content: frozenset[str]) -> Options:
        """Return the options of one of the grammar's alternatives that fill the most slots, with cumulative weights.

        Args:
            choice: the alternatives.
            content: names of the slots that can be filled; an option with others is left out.
        """
        key = id(choice), content
        known = self._options.get(key)
        if known is None:
            known = self._options[key] = choice, self._fullest_options(choice, content)
        return known[1]

    def _fullest_options(self, choice: Alternatives, content: frozenset[str]) -> Options:
        weights = choice.weights or (1.0,) * len(choice.options)
        allowed = [
            (option, weight)
            for option, weight in zip(choice.options, weights, strict=True)
            if weight and self.slots_of(option)[0] <= content
        ]
        most = max(len(self.slots_of(option)[1] & content) for option, _ in allowed)
        fullest = [(option, weight) for option, weight in allowed if len(self.slots_of(option)[1] & content) == most]
        return [option for option, _ in fullest], list(accumulate(weight for _, weight in fullest))

    def fitting(self, patterns: Patterns, content: frozenset[str], filled: frozenset[str]) -> Patterns:
        """Return those of a tuple of the grammar's patterns that are written and express exactly the content.

        Args:
            patterns: the tuple itself, not a copy: results are remembered by its identity.
            content: names of slots, and of attributes with wordings in tables.
            filled: slots of tables that have a wording for the content.
        """
        key = id(patterns), content, filled
        known = self._fitting.get(key)
        if known is None:
            fitting = tuple(p for p in patterns if p.weight and self._expresses(p, content, filled))
            known = self._fitting[key] = patterns, fitting
        return known[1]

    def _expresses(self, pattern: Pattern, content: frozenset[str], filled: frozenset[str]) -> bool:
        tables = self.tables
        must, possible = self.slots_of(pattern.body)
        can = {slot for slot in possible if slot not in tables or slot in filled}
        attributes = {tables[slot].attribute if slot in tables else slot for slot in can}
        required = {tables[slot].attribute if slot in tables else slot for slot in must}
        return must <= can and required <= content <= attributes

    def introduced_slots(self, pattern: Pattern) -> frozenset[str]:
        """Return the slots that one of the grammar's patterns fills with things not mentioned before."""
        known = self._introduced.get(id(pattern.body))
        if known is None:
            slots = (slot.name for slot in pattern.slots() if self.first_mention.intersection(slot.marks))
            known = self._introduced[id(pattern.body)] = (pattern.body, frozenset(slots))
        return known[1]

    def has_words_for(self, noun: Lexeme, pattern: Pattern) -> bool:
        """Return whether each word of one of the grammar's patterns has a form that agrees with a noun."""
        key = id(pattern.body), noun.given
        known = self._worded.get(key)
        if known is None:
            imposed = {axis: self.axes[axis][0] for axis in self.imposed} | dict(noun.given)
            others = {value for axis in self.imposed for value in self.axes[axis]} - set(imposed.values())
            words = [self.words[slot.name] for slot in pattern.slots() if slot.name in self.words]
            agree = all(any(others.isdisjoint(marks) for word in each for marks, _ in word.forms) for each in words)
            known = self._worded[key] = pattern.body, agree
        return known[1]

    def noun_phrases_of(self, kind: str) -> tuple[Pattern, ...]:
        """Return the noun phrases for one thing of a kind: specific to the kind, or general."""
        return self._phrases_of["noun_phrases_of"].get(kind, self.noun_phrases)

    def pair_phrases_of(self, kind: str) -> tuple[Pattern, ...]:
        """Return the noun phrases for two things of a kind described alike: specific to the kind, or general."""
        return self._phrases_of["pair_phrases_of"].get(kind, self.pair_phrases)

    def several_phrases_of(self, kind: str) -> tuple[Pattern, ...]:
        """Return the noun phrases for several things of a kind: specific to the kind, or general."""
        return self._phrases_of["several_phrases_of"].get(kind, self.several_phrases)

    def another_phrases_of(self, kind: str) -> tuple[Pattern, ...]:
        """Return the noun phrases for another thing of a kind ("another bench"): specific to the kind, or general."""
        return self._phrases_of["another_phrases_of"].get(kind, self.another_phrases)

    def same_phrases_of(self, kind: str) -> tuple[Pattern, ...]:
        """Return the noun phrases for a thing mentioned before ("that bench"): specific to the kind, or general."""
        return self._phrases_of["same_phrases_of"].get(kind, self.same_phrases)

    def look_kind(self, kind: str) -> str:
        """Return the key of a kind's looks: the kind if it has its own looks, else "collectible"."""
        kind = LOOKS_AS.get(kind, kind)
        return kind if kind in self.looks else "collectible"

    def word_forms(self) -> dict[str, tuple[str, ...]]:
        """Return all distinct forms of each word."""
        return {name: forms_of(lexemes) for name, lexemes in self.words.items()}

    def spellings(self, pattern: Pattern) -> set[str]:
        """Return all texts of a pattern whose slots are all words."""
        return {" ".join(text.split()) for text in spell_out(pattern.body, self.word_forms())}

    def _tabled(self, name: str, table: Mapping[str, Iterable[str]]) -> dict[str, tuple[Pattern, ...]]:
        return {key: self._patterns(f"{name}.{key}", texts) for key, texts in table.items()}

    def _adjectives(self, name: str, table: Mapping[str, Iterable[str]]) -> dict[str, tuple[Pattern, ...]]:
        for key, texts in table.items():
            for text in texts:
                if text.startswith(AFTER):
                    raise ValueError(f"{name}.{key}: {text!r}: only looks can follow the noun, by {AFTER}")
        return self._tabled(name, table)

    def _wordings(self, name: str, texts: Iterable[str]) -> tuple[LookWording, ...]:
        return tuple(
            LookWording(pattern, text.startswith(AFTER))
            for text in texts
            for pattern in self._patterns(name, [text.removeprefix(AFTER).strip()])
        )

    def _patterns(self, name: str, texts: Iterable[str]) -> tuple[Pattern, ...]:
        patterns = tuple(map(parse, texts))
        for pattern in patterns:
            for slot in pattern.slots():
                if slot.name not in self._slots:
                    raise ValueError(f"{name}: unknown word, table or slot {slot.name!r} in {pattern.text!r}")
                try:
                    self.features_of(slot.marks)
                except ValueError as error:
                    raise ValueError(f"{name}: {pattern.text!r}: {error}") from error
        return patterns

    def _lexemes(self, name: str, entry: Any) -> tuple[Lexeme, ...]:
        entries = entry if isinstance(entry, list) else [entry]
        return tuple(self._lexeme(name, each) for each in entries)

    def _lexeme(self, name: str, entry: str | Mapping[str, Any]) -> Lexeme:
        if isinstance(entry, str):
            weight, text = split_weight(entry)
            return Lexeme(((frozenset(), text),), (), weight)
        listed = dict(entry)
        weight = float(listed.pop("weight", 1.0))
        arms = int(listed.pop("arms", 0))
        given = tuple((axis, listed.pop(axis)) for axis in self.axes if axis in listed)
        if "class" in listed:
            stem = listed.pop("stem", "")
            named = listed.pop("class")
            if named not in self._classes:
                raise ValueError(
                    f"{name}: no class {named!r}; [classes] of grammar.toml has {', '.join(self._classes)}"
                )
            endings = self._classes[named]
            listed = {marks: stem + ending for marks, ending in endings.items()} | listed
        forms = []
        for marks, text in listed.items():
            try:
                forms.append((frozenset(self.features_of(marks.split(".")).values()), text))
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from error
        if not forms:
            raise ValueError(f"{name}: {entry!r} has no form")
        return Lexeme(tuple(forms), given, weight, arms)


def forms_of(lexemes: Iterable[Lexeme]) -> tuple[str, ...]:
    """Return all distinct forms of the lexemes."""
    return tuple(dict.fromkeys(text for lexeme in lexemes for _, text in lexeme.forms))
