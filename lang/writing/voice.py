"""Voice of an episode's instructions: choices of register and vocabulary that one speaker keeps in all texts."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from random import Random
from typing import TypeVar

from arramon_lang.grammar import Grammar, Lexeme, LookWording
from arramon_lang.patterns import Pattern

_T = TypeVar("_T", Lexeme, LookWording, Pattern)


@dataclass(frozen=True, slots=True, eq=False)
class Voice:
    """Choices that one speaker makes once for all texts.

    Attributes:
        features: value for each axis of `text.per_episode` in `grammar.toml`, such as the register in Hindi.
        nouns: noun for each kind of thing.
        junctions: noun by (kind, number of streets), for junctions whose noun depends on that number.
        colours: word for each colour.
        colours_of: the same for kinds of things with colour words of their own.
        whiches: word for each of `arramon_lang.meaning.WHICHES`.
        looks: usual wording by (kind, look).
    """

    features: Mapping[str, str]
    nouns: Mapping[str, Lexeme]
    junctions: Mapping[tuple[str, int], Lexeme]
    colours: Mapping[str, Pattern]
    colours_of: Mapping[str, Mapping[str, Pattern]]
    whiches: Mapping[str, Pattern]
    looks: Mapping[tuple[str, str], LookWording]


def draw_voice(grammar: Grammar, random: Random) -> Voice:
    """Draw a voice by the weights in the language's data."""

    def one(options: Iterable[_T]) -> _T:
        listed = list(options)
        return random.choices(listed, [option.weight for option in listed])[0]

    return Voice(
        {axis: random.choices(list(values), list(values.values()))[0] for axis, values in grammar.per_episode.items()},
        {kind: one(noun for noun in nouns if not noun.arms) for kind, nouns in grammar.nouns.items()},
        {
            (kind, arms): one(noun for noun in nouns if noun.arms == arms)
            for kind, nouns in grammar.nouns.items()
            for arms in sorted({noun.arms for noun in nouns if noun.arms})
        },
        {colour: one(wordings) for colour, wordings in grammar.colours.items()},
        {
            kind: {colour: one(wordings) for colour, wordings in listed.items()}
            for kind, listed in grammar.colours_of.items()
        },
        {which: one(wordings) for which, wordings in grammar.whiches.items()},
        {
            (kind, value): one([wording for wording in wordings if wording.weight and not wording.after] or wordings)
            for kind, values in grammar.looks.items()
            for value, wordings in values.items()
        },
    )
