"""Detection of the things that a navigation text names, by a language's nouns alone, without grammar or plan."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import takewhile

from arramon_lang import load
from arramon_lang.grammar import INSIDE

MARKERS = {
    "en": {
        "same": {"that", "same", "this"}, "other": {"another", "next"}, "two": {"both", "two"},
        "first": {"first"}, "second": {"second"}, "third": {"third"}, "": {"the", "a", "an"},
    },
    "hi": {
        "same": {"उस", "उसी", "वही", "वह", "यह", "इस", "इसी"}, "other": {"और_एक", "अगला", "अगले", "अगली"},
        "two": {"दोनों"}, "first": {"पहला", "पहले", "पहली"}, "second": {"दूसरा", "दूसरे", "दूसरी"},
        "third": {"तीसरा", "तीसरे", "तीसरी"}, "": {"एक"},
    },
}  # fmt: skip
"""Words before a noun that select a thing: determiners and ordinals."""

STRIPED = r"orange and white|white and orange|नारंगी-सफ़ेद|नारंगी और सफ़ेद"
WHITE = {"en": "white", "hi": "सफ़ेद"}
"""What a barrier of two colours is called, and the colour that the files give it."""

AWAY = {"en": r"(toward|towards|face|facing|direction of|see|spot|notice|for)$", "hi": r"^(की (ओर|तरफ़|दिशा)|दिख|न दिख)"}
"""Patterns of things that the walker does not reach: before the noun phrase in English, after it in Hindi."""

RELATIVE = r" (?:को|तक|की (?:ओर|तरफ़|दिशा में)|के साथ-साथ) .*जो "
"""What follows a Hindi noun phrase described by a clause: "take that mug which lies there" refers to none before.

After "behind that car", a clause describes what lies there, and "that car" is the one mentioned before.
"""

STANDING = frozenset({"parked", "खड़ी", "खड़ा", "खड़े"})
"""Words between a noun and its colour without a meaning of their own here."""

JOINING = frozenset({"with", "वाला", "वाले", "वाली"})
"""Words in the wordings of looks that also join other words."""

LINKS = frozenset({"of", "in", "and", "has"})
"""Words in the wordings of looks that may also precede a noun phrase."""


@dataclass(frozen=True)
class ThingMention:
    """A noun phrase: its kind, its colour ("" if not given), its marker, and whether the walker reaches the thing.

    `start` and `end` are where its noun begins, with the words before it that describe it, and where it ends in what
    `plain` returns.
    """

    kind: str
    colour: str
    look: str
    marker: str
    reached: bool
    words: str
    start: int = 0
    end: int = 0


ENGLISH_SIDES = (
    ("लेफ़्ट (?:साइड में|साइड|की तरफ़)", "बाईं ओर"), ("राइट (?:साइड में|साइड|की तरफ़)", "दाईं ओर"),
    ("लेफ़्ट में", "बाएँ"), ("राइट में", "दाएँ"), ("लेफ़्ट वाल", "बाईं ओर वाल"), ("राइट वाल", "दाईं ओर वाल"),
    ("लेफ़्ट", "बाएँ"), ("राइट", "दाएँ"),
)  # fmt: skip
"""English words for sides in Hindi texts, with Hindi ones."""


def plain(text: str, code: str) -> str:
    """Return a text in lower case, without punctuation and with single spaces, as `mentions` expects it."""
    text = re.sub(r"[.,;।]", " ", text.lower())
    text = re.sub(r"\s+", " ", text).replace("एक और ", "और_एक ")
    for pattern, words in ENGLISH_SIDES if code == "hi" else ():
        text = re.sub(pattern, words, text)
    text = re.sub(r"\bso that\b", "so", text)  # "So that the bench is ahead" refers to no bench mentioned before.
    return re.sub(STRIPED, WHITE[code], text)


def mentions(text: str, code: str) -> Iterator[ThingMention]:
    """Yield the things that a text names, in order."""
    text = plain(text, code)
    taken = 0
    for match in _nouns(code).finditer(text):
        if match.start() < taken:
            continue
        taken = match.end()
        kind = _kinds(code)[re.sub(r"\s+", " ", _bare(match))]
        before = text[: match.start()].split()
        modifiers: list[str] = [word for group in match.groups()[1:] if group for word in group.split()]
        while before and before[-1] in _describing(code):
            modifiers.insert(0, before.pop())
        colours = [_colours(code)[word] for word in modifiers if word in _colours(code)]
        shown = re.match(r" (?:with|showing) (?:an? )?(\S+)", text[match.end() :])
        shown_words = [shown[1]] if shown and shown[1] in _looks(code, kind) else []
        looks = [look for word in [*modifiers, *shown_words] for look in _looks(code, kind).get(word, ())]
        markers = [m for word in modifiers for m, words in MARKERS[code].items() if m and word in words]
        if code == "hi" and re.match(RELATIVE, text[match.end() :]):
            markers = [marker for marker in markers if marker != "same"]
        beside = " ".join(before[-2:]) if code == "en" else text[match.end() :].strip()
        away = re.search(AWAY[code], beside) is not None
        yield ThingMention(
            kind, colours[0] if colours else "", looks[0] if looks else "", markers[0] if markers else "", not away,
            " ".join(word for word in [*modifiers, *shown_words] if word not in _determiners(code)),
            len(" ".join([*before, *takewhile(LINKS.__contains__, modifiers), ""])), match.end(),
        )  # fmt: skip


@cache
def _forms(code: str) -> dict[str, str]:
    """Return the kind of each form of each noun, with INSIDE in place of its adjectives.

    Of two kinds with the same noun it is the one that texts name so, not the one that people sometimes do.
    """
    grammar = load(code).grammar
    read = {form.lower(): kind for kind, forms in grammar.also_nouns.items() for form in forms}
    nouns = grammar.nouns.items()
    return read | {form.lower(): kind for kind, lexemes in nouns for each in lexemes for _, form in each.forms if form}


@cache
def _nouns(code: str) -> re.Pattern[str]:
    listed = sorted((form for form, kind in _forms(code).items() if kind), key=len, reverse=True)
    inside = r" ?((?:\S+ ){0,4}?)"
    return re.compile(
        r"(?<!\S)(" + "|".join(re.escape(f).replace(re.escape(INSIDE), inside) for f in listed) + r")(?!\S)"
    )


@cache
def _kinds(code: str) -> dict[str, str]:
    return {form.replace(INSIDE, ""): kind for form, kind in _forms(code).items()}


def _bare(match: re.Match[str]) -> str:
    """Return a noun as listed, without the words inside it."""
    inside = [match.span(number) for number in range(2, len(match.groups()) + 1) if match[number]]
    text, (start, _) = match[1], match.span(1)
    for first, last in reversed(inside):
        text = text[: first - start] + text[last - start :]
    return text


@cache
def _colours(code: str) -> dict[str, str]:
    grammar = load(code).grammar
    return {w: c for c, ps in grammar.colours.items() for p in ps for s in grammar.spellings(p) for w in s.split()[:1]}


@cache
def _looks(code: str, kind: str) -> dict[str, list[str]]:
    """Return the looks that each word identifies, for a kind; words of several looks identify none."""
    grammar = load(code).grammar
    found: dict[str, set[str]] = {}
    for look, wordings in grammar.looks.get(grammar.look_kind(kind), {}).items():
        for wording in (each for each in wordings if each.weight):
            for text in grammar.spellings(wording.wording):
                for word in set(text.split()) - _determiners(code) - JOINING:
                    found.setdefault(word, set()).add(look)
    return {word: sorted(looks) for word, looks in found.items() if len(looks) == 1}


@cache
def _determiners(code: str) -> frozenset[str]:
    return frozenset(word for words in MARKERS[code].values() for word in words)


@cache
def _describing(code: str) -> frozenset[str]:
    """Return all words that may be part of a noun phrase before its noun."""
    grammar = load(code).grammar
    words = {w for ps in grammar.colours.values() for p in ps for s in grammar.spellings(p) for w in s.split()}
    for looks in grammar.looks.values():
        words |= {w for ws in looks.values() for x in ws for s in grammar.spellings(x.wording) for w in s.split()}
    return frozenset(words - {"a", "with", "on", "it", "and", "और"}) | _determiners(code) | STANDING
