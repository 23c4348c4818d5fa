"""Notation of phrase patterns in a language's files: words, slots and alternatives.

{name}          a slot: filled with a value, or with an inflected word
{name:a.b}      the same with marks: required features ("oblique", "plural")
(this|that)     one of the alternatives
[this|that]     one of the alternatives, or nothing
3* in front of a pattern or an alternative: its weight; 0* is read but never written
<name>          a fragment, inserted verbatim; only in patterns that are only read
^ at the front  valid as a main clause only, never in another form ("after walking ...")
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

_PIECE = re.compile(r"\{([^{}:]+)(?::([^{}]+))?\}|([(\[|)\]])|(\d+(?:\.\d+)?)\*\s*|([^{}()\[\]|]+)|(.)", re.DOTALL)
_WEIGHT = re.compile(r"(\d+(?:\.\d+)?)\*\s*")
_FRAGMENT = re.compile(r"<(\w+)>")


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot; `marks` are the grammatical features that its text must have."""

    name: str
    marks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Alternatives:
    """Alternative sequences; an empty one makes the whole optional.

    Attributes:
        options: the sequences.
        weights: relative probability of each option; empty if they are equal.
    """

    options: tuple["Sequence", ...]
    weights: tuple[float, ...] = ()


Sequence: TypeAlias = tuple["str | Slot | Alternatives", ...]


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """One wording. Instances are compared by identity.

    Attributes:
        body: its parts, in order.
        main_only: whether it is valid as a main clause only.
        text: its notation.
        weight: relative probability of being written; 0 if it is only read.
    """

    body: Sequence
    main_only: bool
    text: str
    weight: float = 1.0

    def slots(self) -> tuple[Slot, ...]:
        """Return all slots, including those in alternatives."""
        return tuple(_slots(self.body))


def parse(text: str) -> Pattern:
    """Parse a pattern.

    Raises:
        ValueError: if its brackets do not match; names the pattern.
    """
    weight, rest = split_weight(text)
    main_only = rest.startswith("^")
    pieces = list(_PIECE.finditer(rest, 1 if main_only else 0))[::-1]
    return Pattern(_parse(pieces, "", text).options[0], main_only, text, weight)


def with_fragments(text: str, fragments: Mapping[str, str]) -> str:
    """Return the notation with its fragments expanded, recursively.

    Raises:
        ValueError: if a fragment is not known; names the pattern.
    """
    while name := _FRAGMENT.search(text):
        if name[1] not in fragments:
            raise ValueError(f"pattern {text!r}: unknown fragment {name[1]!r}; expected one of {', '.join(fragments)}")
        text = text[: name.start()] + fragments[name[1]] + text[name.end() :]
    return text


def split_weight(text: str) -> tuple[float, str]:
    """Split the leading weight off a text ("3* walk"); it is 1 by default."""
    weight = _WEIGHT.match(text)
    return (float(weight[1]), text[weight.end() :]) if weight else (1.0, text)


_CLOSING = {"(": ")", "[": "]"}


def _parse(pieces: list[re.Match[str]], closing: str, text: str) -> Alternatives:
    options: list[list[str | Slot | Alternatives]] = [[]]
    weights = [1.0]
    while pieces:
        slot, marks, bracket, weight, literal, wrong = pieces.pop().groups()
        if wrong is not None:
            break
        if slot is not None:
            options[-1].append(Slot(slot.strip(), tuple(marks.split(".")) if marks else ()))
        elif weight is not None:
            weights[-1] = float(weight)
        elif literal is not None:
            options[-1].append(literal)
        elif bracket in _CLOSING:
            options[-1].append(_parse(pieces, _CLOSING[bracket], text))
        elif bracket == "|" and closing:
            options.append([])
            weights.append(1.0)
        elif bracket == closing:
            return _choice(options, weights, optional=closing == "]")
        else:
            break
    else:
        if not closing:
            return _choice(options, weights, optional=False)
    raise ValueError(f"pattern {text!r}: unbalanced brackets")


def _choice(options: list[list[str | Slot | Alternatives]], weights: list[float], *, optional: bool) -> Alternatives:
    nothing: list[list[str | Slot | Alternatives]] = [[]] if optional else []
    weights = [*weights, 1.0] if optional else weights
    return Alternatives(tuple(map(tuple, [*options, *nothing])), () if set(weights) == {1.0} else tuple(weights))


def required_slots(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Return the `fillable` slots that every variant of the sequence contains."""
    names: set[str] = set()
    for part in body:
        if isinstance(part, Slot) and part.name in fillable:
            names.add(part.name)
        elif isinstance(part, Alternatives):
            names |= frozenset.intersection(*(required_slots(option, fillable) for option in part.options))
    return frozenset(names)


def possible_slots(body: Sequence, fillable: frozenset[str]) -> frozenset[str]:
    """Return the `fillable` slots that some variant of the sequence contains."""
    return frozenset(slot.name for slot in _slots(body) if slot.name in fillable)


def _slots(body: Sequence) -> Iterator[Slot]:
    for part in body:
        if isinstance(part, Slot):
            yield part
        elif isinstance(part, Alternatives):
            for option in part.options:
                yield from _slots(option)


def spell_out(body: Sequence, forms: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Yield every text that the sequence can produce; `forms` are the possible texts of each slot.

    Raises:
        KeyError: if a slot has no forms.
    """
    if not body:
        yield ""
        return
    first, rest = body[0], body[1:]
    if isinstance(first, Alternatives):
        heads = [text for option in first.options for text in spell_out(option, forms)]
    else:
        heads = [first] if isinstance(first, str) else list(forms[first.name])
    tails = list(spell_out(rest, forms))
    for head in heads:
        for tail in tails:
            yield head + tail
