"""The notation for phrases in a language's files: words, slots, choices.

{name}          a slot: filled with a value, or with an inflected word
{name:a.b}      the same with marks: required features ("oblique", "plural")
(this|that)     one of these
[this|that]     one of these or nothing
^ at the front  a main clause only: never transformed ("after walking ...")
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

_PIECE = re.compile(r"\{([^{}:]+)(?::([^{}]+))?\}|([(\[|)\]])|([^{}()\[\]|]+)|(.)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Slot:
    """A place to be filled; `marks` are the features required of its filling."""

    name: str
    marks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several sequences; an empty one makes it optional."""

    options: tuple["Sequence", ...]


Sequence: TypeAlias = tuple["str | Slot | Choice", ...]


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """One wording. Instances are compared by identity: a wording that is listed twice is chosen twice as often.

    Attributes:
        body: its parts, in order.
        main_only: whether it is valid as a main clause only.
        text: its notation.
    """

    body: Sequence
    main_only: bool
    text: str

    def slots(self) -> tuple[Slot, ...]:
        """Return all slots, including those in choices."""
        return tuple(_slots(self.body))


def parse(text: str) -> Pattern:
    """Parse a pattern.

    Raises:
        ValueError: if its brackets do not match; names the pattern.
    """
    main_only = text.startswith("^")
    pieces = list(_PIECE.finditer(text, 1 if main_only else 0))[::-1]
    body = _parse(pieces, "", text)
    return Pattern(body[0], main_only, text)


_CLOSING = {"(": ")", "[": "]"}


def _parse(pieces: list[re.Match[str]], closing: str, text: str) -> tuple[Sequence, ...]:
    options: list[list[str | Slot | Choice]] = [[]]
    while pieces:
        slot, marks, bracket, literal, wrong = pieces.pop().groups()
        if wrong is not None:
            break
        if slot is not None:
            options[-1].append(Slot(slot.strip(), tuple(marks.split(".")) if marks else ()))
        elif literal is not None:
            options[-1].append(literal)
        elif bracket in _CLOSING:
            inner = _parse(pieces, _CLOSING[bracket], text)
            options[-1].append(Choice(inner if bracket == "(" else (*inner, ())))
        elif bracket == "|" and closing:
            options.append([])
        elif bracket == closing:
            return tuple(map(tuple, options))
        else:
            break
    else:
        if not closing:
            return tuple(map(tuple, options))
    raise ValueError(f"pattern {text!r}: unbalanced brackets")


def needed(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Return the `fillable` slots that are in every variant of the sequence."""
    names: set[str] = set()
    for part in body:
        if isinstance(part, Slot) and part.name in fillable:
            names.add(part.name)
        elif isinstance(part, Choice):
            names |= frozenset.intersection(*(needed(option, fillable) for option in part.options))
    return frozenset(names)


def possible(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Return the `fillable` slots that are in some variant of the sequence."""
    return frozenset(slot.name for slot in _slots(body) if slot.name in fillable)


def _slots(body: Sequence) -> Iterator[Slot]:
    for part in body:
        if isinstance(part, Slot):
            yield part
        elif isinstance(part, Choice):
            for option in part.options:
                yield from _slots(option)


def spell_out(body: Sequence, forms: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Yield every text of the sequence; `forms` are the possible fillings of each slot.

    Raises:
        KeyError: if a slot has no forms.
    """
    if not body:
        yield ""
        return
    first, rest = body[0], body[1:]
    if isinstance(first, Choice):
        heads = [text for option in first.options for text in spell_out(option, forms)]
    else:
        heads = [first] if isinstance(first, str) else list(forms[first.name])
    tails = list(spell_out(rest, forms))
    for head in heads:
        for tail in tails:
            yield head + tail
