"""Mentions of collectibles in any text, for quality checks and missing objects; `parser.py` parses instructions."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from arramon_lang.lexicon import JOINTS, Lexicon, LexiconEntry, WordRole
from arramon_lang.tokens import Token

_ATTRIBUTES = (WordRole.PATTERN, WordRole.COLOUR)

_COMMAS = (",", "/")
"""Punctuation allowed within a noun phrase: "the dotted, green ball"."""


@dataclass(frozen=True, slots=True)
class Mention:
    """A noun phrase for a collectible, possibly incomplete, with the catalogue's names.

    Attributes:
        pattern: "dotted" or "striped"; None if not stated.
        colour: "green", "red", "blue", "white", "yellow", "brown" or "purple"; None if not stated.
        kind: "ball", "hourglass", "mug", "tv", "book", "bowl" or "bucket"; None if not stated.
        start: index of the phrase's first character, without articles, in the text as given.
        end: index after its last character.
    """

    pattern: str | None
    colour: str | None
    kind: str | None
    start: int
    end: int


@dataclass(slots=True)
class _Phrase:
    """A noun phrase before its noun."""

    first: int = -1
    attributes: dict[WordRole, str] = field(default_factory=dict)

    def add(self, word: LexiconEntry, at: int) -> None:
        if word.role in self.attributes:  # A second colour begins another phrase.
            self.first, self.attributes = at, {}
        if self.first < 0:
            self.first = at
        if word.role in _ATTRIBUTES:
            self.attributes[word.role] = word.value


def find_mentions(tokens: Sequence[Token], lexicon: Lexicon) -> list[Mention]:
    """Return the mentions of collectibles, in order.

    A phrase without a kind counts if it has both a pattern and a colour, or a stand-in for the kind ("the dotted one");
    "the striped wall" and "the red banner" do not.
    """
    tokens = [token for token in tokens if token.text not in JOINTS]
    keys = [token.key for token in tokens]
    mentions = []
    phrase, i = _Phrase(), 0
    while i < len(tokens):
        word = lexicon.read(keys, i)
        if word is None or word.role is WordRole.HAVING:
            if not (keys[i] in _COMMAS and phrase.first >= 0):
                mentions += _kindless(phrase, tokens, i, stand_in=False)
                phrase = _Phrase()
            i += 1
        elif word.role in (*_ATTRIBUTES, WordRole.MODIFIER):
            if word.role in phrase.attributes:
                mentions += _kindless(phrase, tokens, i, stand_in=False)
            phrase.add(word, i)
            i += word.length
        elif _is_kind(word.role, phrase):
            first = phrase.first if phrase.first >= 0 else i
            i += word.length
            pattern, i = _described_after(phrase.attributes.get(WordRole.PATTERN), keys, i, lexicon)
            start, end = tokens[first].start, tokens[i - 1].end
            mentions.append(Mention(pattern, phrase.attributes.get(WordRole.COLOUR), word.value, start, end))
            phrase = _Phrase()
        else:
            i += word.length
            if word.role is WordRole.STAND_IN:
                mentions += _kindless(phrase, tokens, i, stand_in=True)
            phrase = _Phrase()
    return mentions + _kindless(phrase, tokens, len(tokens), stand_in=False)


def _is_kind(role: WordRole, phrase: _Phrase) -> bool:
    return role is WordRole.KIND or (role is WordRole.PATTERNED_KIND and WordRole.PATTERN in phrase.attributes)


def _kindless(phrase: _Phrase, tokens: Sequence[Token], after: int, *, stand_in: bool) -> list[Mention]:
    """Return a phrase that ends before `tokens[after]` as a mention without kind, if it states enough attributes."""
    if not phrase.attributes or (len(phrase.attributes) < len(_ATTRIBUTES) and not stand_in):
        return []
    last = after - 2 if tokens[after - 1].text in _COMMAS else after - 1
    pattern, colour = phrase.attributes.get(WordRole.PATTERN), phrase.attributes.get(WordRole.COLOUR)
    return [Mention(pattern, colour, None, tokens[phrase.first].start, tokens[last].end)]


def _described_after(pattern: str | None, keys: Sequence[str], i: int, lexicon: Lexicon) -> tuple[str | None, int]:
    """Return the pattern, possibly stated after the noun ("with black dots"), and the index after it.

    A pattern before another noun ("with a striped red bowl") belongs to that noun.
    """
    having = lexicon.read(keys, i) if i < len(keys) and pattern is None else None
    if having is None or having.role is not WordRole.HAVING:
        return pattern, i
    described, after = None, i + having.length
    while after < len(keys) and (word := lexicon.read(keys, after)) is not None:
        if word.role is WordRole.PATTERN and described is None:
            described = word.value
        elif word.role is not WordRole.MODIFIER:
            return pattern, i
        after += word.length
    return (described, after) if described else (pattern, i)
