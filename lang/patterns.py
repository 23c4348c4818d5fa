"""The notation in which a language's files say how something is put: words, slots, choices.

{name}          a slot: what is filled in, or an inflected word
{name:a.b}      the same with marks: the features that it is to have ("oblique", "plural")
(this|that)     one of these
[this|that]     one of these or nothing
^ at the front  a main clause only: never put into another form ("after walking ...")
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

_PIECE = re.compile(r"\{([^{}:]+)(?::([^{}]+))?\}|([(\[|)\]])|([^{}()\[\]|]+)|(.)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Slot:
    """A place to be filled; `marks` are features that what fills it is to have."""

    name: str
    marks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several sequences; an empty one makes it optional."""

    options: tuple["Sequence", ...]


Sequence: TypeAlias = tuple["str | Slot | Choice", ...]


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """One way to put something. Two that are alike are two: one that is listed twice is written twice as often.

    Attributes:
        body: its parts in order.
        main_only: whether it can only be a main clause.
        text: as it was written.
    """

    body: Sequence
    main_only: bool
    text: str

    def slots(self) -> tuple[Slot, ...]:
        """All slots in it, those in choices included."""
        return tuple(_slots(self.body))


def parse(text: str) -> Pattern:
    """The pattern that is written so.

    Raises:
        ValueError: naming the pattern, where its brackets do not match.
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
    raise ValueError(f"pattern {text!r}: its brackets do not match")


def needed(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Those of the `fillable` slots that every reading of the sequence has."""
    names: set[str] = set()
    for part in body:
        if isinstance(part, Slot) and part.name in fillable:
            names.add(part.name)
        elif isinstance(part, Choice):
            names |= frozenset.intersection(*(needed(option, fillable) for option in part.options))
    return frozenset(names)


def possible(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Those of the `fillable` slots that some reading of the sequence has."""
    return frozenset(slot.name for slot in _slots(body) if slot.name in fillable)


def _slots(body: Sequence) -> Iterator[Slot]:
    for part in body:
        if isinstance(part, Slot):
            yield part
        elif isinstance(part, Choice):
            for option in part.options:
                yield from _slots(option)


def spell_out(body: Sequence, forms: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Every text that the sequence can be, `forms` being what each slot can be filled with.

    Raises:
        KeyError: for a slot without forms.
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
