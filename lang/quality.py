"""Quality checks of instructions, from the paper's appendix ("Data Collection"), for all languages.

Each language's words are data, in its `quality.toml`. A failed check either blocks an instruction, as the paper's
automated checks do, or marks it as suspicious for a reviewer, following the paper's guidelines for writers.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from arramon_client.world import PHASES
from arramon_lang.files import read_file
from arramon_lang.language import ROOT, Language, language_folder, load
from arramon_lang.meaning import Thing
from arramon_lang.tokens import PAUSES, SENTENCE_ENDS, strip_marks

BLOCKED = "blocked"
SUSPICIOUS = "suspicious"


MIN_WORDS = 6
"""Minimum number of words of an instruction, unless a language's `quality.toml` has another."""

MAX_SPACES = 0.4
MIN_UNIQUE = 0.4
SYMBOLS = "([])&*^%$#@!=+"

MAX_WORDS = 100
"""Word count above which a text is suspicious; the longest in the release's val-seen has 97 words."""

MIN_TURN = 45.0
"""Initial turn of the path, in degrees, above which the text must say "turn". The paper gives no value. In val-seen of
the release, 29% of the 319 instructions that start with a turn of 30 degrees lack "turn", and 0.2% of those with
more."""

_TABLES = frozenset(("general", *PHASES, "wanted", "suspicious", "counts", "landmarks", "registers", "misspelt"))
_KEYS = {
    "wanted": frozenset(("turn", "pick_up", "place")),
    "suspicious": frozenset(("movement", "interface", "grey_building", "earlier")),
    "counts": frozenset(("numbers", "units")),
    "landmarks": frozenset(("words",)),
}

_SPACE_BEFORE_MARK = re.compile(rf"\s[{PAUSES}{SENTENCE_ENDS}?؟](?!\w)")


@dataclass(frozen=True, slots=True)
class Failure:
    """A failed check of a text.

    Attributes:
        check: name of the check, such as "few_words" or "term"; the same in every language.
        severity: BLOCKED or SUSPICIOUS.
        message: the words at fault, what is wrong with them, and what was expected.
        words: the words, symbols or letters at fault, normalised and case-folded; empty if the whole text is, or if
            something is missing. `quality_marks.marks` finds them in the text.
        expected: what was expected instead, in words of the language or a number; "" where the check alone says it.
        term: of the check "term", the paper's name of the forbidden words, such as "go back"; "" otherwise.
    """

    check: str
    severity: str
    message: str
    words: tuple[str, ...] = ()
    expected: str = ""
    term: str = ""

    def __str__(self) -> str:
        return f"{self.severity}: {self.check}: {self.message}"


def check(
    text: str,
    language: str,
    phase: str,
    *,
    target: Thing | None = None,
    first_turn: float = 0.0,
    root: Path = ROOT,
) -> tuple[Failure, ...]:
    """Return the failed checks of an instruction, blocking ones first.

    Args:
        text: as written by a person or a program.
        language: code of the expected language.
        phase: one of PHASES.
        target: the object to pick up or place, with the attributes that the text must not contradict; None to skip this
            check.
        first_turn: absolute angle in degrees of the ground-truth path's turn before its first step forward.
        root: folder that contains the languages' folders.

    Raises:
        UnknownLanguage: if the language does not exist.
        ValueError: if the phase is unknown, or the language's `quality.toml` has missing or unknown keys.
    """
    if phase not in PHASES:
        raise ValueError(f"phase {phase!r} is not one of {', '.join(map(repr, PHASES))}")
    rules = _rules(language, root)
    spelt = load(language, root)
    words = _Words(text, spelt)
    blocked = [*_general(text, words, rules), *_terms(words, rules, phase)]
    if phase == "navigation" and first_turn > MIN_TURN and not words.first_of(rules.wanted["turn"]):
        blocked.append(
            Failure(
                "no_turn",
                BLOCKED,
                f"the path begins with a turn of {first_turn:.0f} degrees; expected {_quoted(rules.wanted['turn'])}",
                expected=" ".join(rules.wanted["turn"][0].words),
            )
        )
    return (*blocked, *_suspicious(text, words, rules, phase, spelt, target))


def any_blocks(failures: Iterable[Failure]) -> bool:
    """Return whether any of the failures blocks the instruction."""
    return any(failure.severity == BLOCKED for failure in failures)


class _Words:
    """Words of a text: split at white space, and as case-folded tokens for the search of terms."""

    def __init__(self, text: str, language: Language) -> None:
        tokens = language.tokenize(text)
        self.spaced = [stripped for piece in language.normalise(text).split() if (stripped := strip_marks(piece))]
        self.keys = [token.casefold() for token in tokens if _is_word(token)]
        self._line = f" {' '.join(self.keys)} "

    def first_of(self, terms: Iterable["_Term"]) -> str:
        """Return the words of the first term found in the text, or ""."""
        found = [(at, len(term.words)) for term in terms if (at := self._line.find(term.sought)) >= 0]
        if not found:
            return ""
        at, length = min(found, key=lambda each: each[0])
        start = self._line.count(" ", 0, at)
        return " ".join(self.keys[start : start + length])


@dataclass(frozen=True, slots=True)
class _Term:
    """A sequence of words to search for; if `open_ended`, the last one is a prefix.

    Attributes:
        sought: the words as in a line whose words all have a space before and after them.
    """

    words: tuple[str, ...]
    open_ended: bool
    sought: str

    def __str__(self) -> str:
        return " ".join(self.words) + "..." * self.open_ended


Terms = tuple[_Term, ...]


class _Rules:
    """Content of one language's `quality.toml`; the comments in `lang/en` describe the keys."""

    def __init__(self, data: Mapping[str, Any], language: Language) -> None:
        missing = {"single_letters", "repeats", *_TABLES} ^ (set(data) - {"min_words"})
        for table, keys in _KEYS.items():
            missing |= {f"{table}.{key}" for key in keys ^ set(data.get(table, ()))}
        if missing:
            raise ValueError(f"lang/{language.code}/quality.toml: missing or unknown: {', '.join(sorted(missing))}")

        def terms(listed: Iterable[str]) -> Terms:
            return tuple(_term(term, language) for term in listed)

        self.min_words: int = data.get("min_words", MIN_WORDS)
        self.single_letters = frozenset(language.normalise(letter).casefold() for letter in data["single_letters"])
        self.repeats = frozenset(map(language.normalise, data["repeats"]))
        self.forbidden: dict[str, dict[str, Terms]] = {
            phase: {term: terms(listed) for term, listed in (data["general"] | data[phase]).items()} for phase in PHASES
        }
        self.wanted = {key: terms(listed) for key, listed in data["wanted"].items()}
        self.suspicious = {key: terms(listed) for key, listed in data["suspicious"].items()}
        self.numbers = frozenset(map(language.normalise, data["counts"]["numbers"]))
        self.units = frozenset(map(language.normalise, data["counts"]["units"]))
        self.landmarks = terms(data["landmarks"]["words"])
        self.registers = {name: terms(listed) for name, listed in data["registers"].items()}
        self.misspelt = {language.normalise(wrong): right for wrong, right in data["misspelt"].items()}


@cache
def _rules(code: str, root: Path) -> _Rules:
    language = load(code, root)
    return _Rules(read_file(language_folder(code, root), "quality"), language)


def _term(written: str, language: Language) -> _Term:
    words = tuple(token.casefold() for token in language.tokenize(written) if _is_word(token))
    is_open = written.endswith("*")
    return _Term(words, is_open, f" {' '.join(words)}{'' if is_open else ' '}")


def _general(text: str, words: _Words, rules: _Rules) -> Iterator[Failure]:
    """Yield failures of the paper's general checks, except those of terms."""

    def blocked(name: str, message: str, *at_fault: str, expected: str = "") -> Failure:
        return Failure(name, BLOCKED, message, at_fault, expected)

    if len(words.spaced) < rules.min_words:
        few = f"{len(words.spaced)} words; expected at least {rules.min_words}"
        yield blocked("few_words", few, expected=str(rules.min_words))
    if text and sum(map(str.isspace, text)) >= MAX_SPACES * len(text):
        yield blocked("spaces", f"{sum(map(str.isspace, text))} of {len(text)} characters are spaces")
    for symbol in sorted(set(text) & set(SYMBOLS)):
        yield blocked("symbol", f"{symbol!r}; these cannot be included: {' '.join(SYMBOLS)}", symbol)
    for word in words.spaced:
        if len(word) == len(_letters(word)) == 1 and word.casefold() not in rules.single_letters:
            yield blocked("single_letter", f"{word!r} is a single letter", word.casefold())
    if repeated := _tripled_letter(text):
        yield blocked("repeated_letter", f"{repeated!r} repeats a letter three times", repeated)
    keys = [word.casefold() for word in words.spaced]
    for first, second in pairwise(keys):
        if first == second and first not in rules.repeats:
            yield blocked("repeated_word", f"{first!r} occurs twice in a row", f"{first} {second}")
    if len(set(keys)) < MIN_UNIQUE * len(keys):
        yield blocked("few_unique", f"{len(set(keys))} different words of {len(keys)}; expected {MIN_UNIQUE:.0%}")


def _terms(words: _Words, rules: _Rules, phase: str) -> Iterator[Failure]:
    for term, listed in rules.forbidden[phase].items():
        if found := words.first_of(listed):
            called = "" if found == term else f" ({term})"
            yield Failure("term", BLOCKED, f"{found!r}{called} cannot be included", (found,), term=term)


def _suspicious(
    text: str, words: _Words, rules: _Rules, phase: str, language: Language, target: Thing | None
) -> Iterator[Failure]:
    """Yield failures of the guidelines for writers that can be checked automatically."""

    def suspicious(name: str, message: str, *at_fault: str, expected: str = "") -> Failure:
        return Failure(name, SUSPICIOUS, message, at_fault, expected)

    for name, listed in rules.suspicious.items():
        if (name != "movement" or phase == "assembly") and (found := words.first_of(listed)):
            yield suspicious(name, f"{found!r}", found)
    action = "pick_up" if phase == "navigation" else "place"
    if not words.first_of(rules.wanted[action]):
        wanted = rules.wanted[action]
        yield suspicious(
            f"no_{action}", f"expected a word such as {_quoted(wanted)}", expected=" ".join(wanted[0].words)
        )
    for number, unit in pairwise(words.keys):
        if unit in rules.units and (number.isdigit() or number in rules.numbers):
            yield suspicious("count", f"'{number} {unit}' counts movements", f"{number} {unit}")
    if len(words.spaced) > MAX_WORDS:
        yield suspicious("long", f"{len(words.spaced)} words; more than {MAX_WORDS} are rare")
    if not language.is_in_own_script(text):
        yield suspicious("script", f"less than half of the letters are {language.script}")
    if phase == "assembly" and not words.first_of(rules.landmarks) and not _has_relation(text, language):
        yield suspicious("no_landmark", "names no landmark for the placement")
    if target is not None and not _names_target(text, language, target):
        called = " ".join(filter(None, (target.look, target.colour, target.kind)))
        yield suspicious("no_target", f"does not name the {called}", expected=called)
    yield from _spelling(text, words, rules, language)


def _spelling(text: str, words: _Words, rules: _Rules, language: Language) -> Iterator[Failure]:
    for word in words.keys:
        if word in rules.misspelt:
            right = rules.misspelt[word]
            yield Failure("misspelt", SUSPICIOUS, f"{word!r}; expected {right!r}", (word,), right)
    if _SPACE_BEFORE_MARK.search(text):
        yield Failure("space_before_mark", SUSPICIOUS, "a space before punctuation")
    if language.without_spelt_joiners(text).split() != language.normalise(text).split():
        yield Failure("normalisation", SUSPICIOUS, "not in Unicode's NFC, or contains characters without meaning")
    used = {name: found for name, listed in rules.registers.items() if (found := words.first_of(listed))}
    if len(used) > 1:
        mixed = " and ".join(f"{found!r} ({name})" for name, found in used.items())
        yield Failure("registers", SUSPICIOUS, f"mixes {mixed}", tuple(used.values()))


def _has_relation(text: str, language: Language) -> bool:
    """Return whether the text relates something to a mentioned object."""
    return any(language.relation_of(text, mention) for mention in language.find_objects(text))


def _names_target(text: str, language: Language, target: Thing) -> bool:
    """Return whether the text mentions an object whose stated attributes all match the target."""
    wanted = (target.kind, target.colour, target.look)
    for mention in language.find_objects(text):
        stated = (mention.kind, mention.colour, mention.pattern)
        if any(stated) and all(not s or not w or s == w for s, w in zip(stated, wanted, strict=True)):
            return True
    return False


def _quoted(terms: Iterable[_Term]) -> str:
    return repr(str(next(iter(terms))))


def _letters(text: str) -> str:
    """Return the letters of a text, without combining signs."""
    return "".join(filter(str.isalpha, text))


def _is_word(token: str) -> bool:
    return any(character.isalnum() for character in token)


def _tripled_letter(text: str) -> str:
    """Return the first three equal letters in a row, or ""."""
    spelt = text.casefold()
    for letters in zip(spelt, spelt[1:], spelt[2:], strict=False):
        if letters[0].isalpha() and len(set(letters)) == 1:
            return "".join(letters)
    return ""
