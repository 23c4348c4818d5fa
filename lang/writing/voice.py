"""Voice of an episode's instructions: choices of register and vocabulary that one speaker keeps in all texts."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import accumulate
from random import Random
from typing import TypeVar

from arramon_lang.grammar import Grammar, Lexeme, LookWording
from arramon_lang.patterns import Pattern

_T = TypeVar("_T", Lexeme, LookWording, Pattern)


@dataclass(frozen=True, slots=True)
class Manner:
    """How much a speaker says, and of what; the same in all languages of an episode.

    Attributes:
        name: of the manner.
        weight: relative number of speakers.
        brevity: preference for short texts: log-odds of a text per word less.
        sentence_sizes: distribution of the number of clauses per sentence.
        openings: factor on the probability of opening words ("Then").
        says_more: factor on the probabilities of steps and relations that the way does not need.
        landmarks, directions: factor on the probability of naming a landmark to face, and of stating sides.
    """

    name: str
    weight: float
    brevity: float
    sentence_sizes: tuple[int, ...]
    openings: float
    says_more: float
    landmarks: float = 1.0
    directions: float = 1.0


MANNERS = (
    Manner("plain", 4.0, 0.03, (1, 1, 2, 2, 2, 3), 1.0, 1.0),
    Manner("terse", 3.0, 1.3, (1, 2, 2, 3), 0.3, 0.3),
    Manner("thorough", 2.0, -0.6, (1, 1, 1, 2, 2), 1.2, 2.0),
    Manner("chatty", 1.0, -0.06, (1, 2, 2, 3), 2.0, 1.5),
    Manner("landmarks", 2.0, 0.0, (1, 1, 2, 2), 0.7, 1.5, 1.6, 0.5),
    Manner("directions", 1.5, 0.02, (1, 2, 2, 3), 1.0, 0.7, 0.5, 2.0),
)
"""Manners of people's texts, by eye."""


def draw_manner(random: Random) -> Manner:
    """Draw a manner by weight."""
    return random.choices(MANNERS, [manner.weight for manner in MANNERS])[0]


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
        manner: how much this speaker says.
        end: mark at the end of a text; "" for speakers who type none.
        has_capitals: whether sentences begin with a capital, in scripts that have them.
        has_articles: whether articles are written, in languages that say which words these are.
        favourites: the form most often written of each word of `text.favourites` in `grammar.toml`.
    """

    features: Mapping[str, str]
    nouns: Mapping[str, Lexeme]
    junctions: Mapping[tuple[str, int], Lexeme]
    colours: Mapping[str, Pattern]
    colours_of: Mapping[str, Mapping[str, Pattern]]
    whiches: Mapping[str, Pattern]
    looks: Mapping[tuple[str, str], LookWording]
    manner: Manner
    end: str
    has_capitals: bool
    has_articles: bool
    favourites: Mapping[str, Lexeme]


def draw_voice(grammar: Grammar, random: Random, manner: Manner | None = None) -> Voice:
    """Draw a voice by the weights in the language's data, with the given manner or a random one."""

    def one(options: Iterable[_T]) -> _T:
        listed = list(options)
        return random.choices(listed, [option.weight**grammar.evenness for option in listed])[0]

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
        manner or draw_manner(random),
        random.choices(list(grammar.ends), list(grammar.ends.values()))[0],
        random.random() >= grammar.small_letters,
        random.random() >= grammar.articles_left_out,
        {
            name: word
            for group, at in ((group, random.random()) for group in grammar.favourites)
            for name, word in ((name, _at(grammar.words[name], at)) for name in group)
        },
    )


def _at(words: tuple[Lexeme, ...], share: float) -> Lexeme:
    """Return the word at a share (0 to 1) of the cumulative weights."""
    bounds = list(accumulate(word.weight for word in words))
    return next(word for word, bound in zip(words, bounds, strict=True) if bound > share * bounds[-1])
