"""Hindi in Latin letters as people type it: each writer has habits, and does not keep to them always."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random

from arramon_dataset.forms.tables import DEVANAGARI, Weights, draw, spellings

_HABIT = 0.85
"""Share of letters that a writer spells by habit."""

_WORD = re.compile(f"[{DEVANAGARI}]+")

_VOWEL_OF_SIGN = dict(zip("ािीुूेैोौॉ", "आइईउऊएऐओऔऑ", strict=True))

_VIRAMA, _NASALS, _DOT = "्", "ंँ", "़"

_INDEPENDENT = "अआइईउऊएऐओऔऑ"


@dataclass(frozen=True, slots=True)
class _Sound:
    """A consonant, a vowel or a nasal of a word, as a Devanagari letter; "" for an inherent vowel."""

    letter: str
    kind: str


@dataclass(slots=True)
class Romaniser:
    """One writer of Hindi in Latin letters.

    Attributes:
        random: source of all choices.
    """

    random: Random
    _habits: dict[str, str] = field(default_factory=dict)

    def text(self, text: str) -> str:
        """Return a Hindi text in Latin letters; words already in Latin letters stay as they are."""
        romanised = _WORD.sub(lambda match: self._word(match.group()), text)
        return romanised.replace("।", "." if self._habitual("।", {".": 3, ",": 1, "none": 1}) else "")

    def _word(self, word: str) -> str:
        tables = spellings()
        if word in tables["english"]:
            return str(tables["english"][word])
        if word in tables["words"]:
            return self._habitual(word, tables["words"][word])
        stem = word.removesuffix("कर")
        if stem != word and len(stem) > 1:
            return self._spelt(list(_sounds(stem))) + self._habitual("participles", tables["participles"])
        return self._spelt(list(_sounds(word)))

    def _spelt(self, sounds: list[_Sound]) -> str:
        tables, letters = spellings(), ""
        for at, sound in enumerate(sounds):
            is_last = all(each.kind == "nasal" for each in sounds[at + 1 :])
            if sound.kind == "consonant":
                letters += self._habitual(sound.letter, tables["letters"][sound.letter])
            elif sound.kind == "nasal":
                following = "n" if not (at + 1 < len(sounds) and sounds[at + 1].letter in ("प", "ब", "भ")) else "m"
                place = "final_nasals" if at + 1 == len(sounds) else "inner_nasals"
                letters += following if self._habitual(place, tables[place]) else ""
            elif sound.letter == "":
                letters += "a"
            else:
                if at and sounds[at - 1].kind == "vowel":
                    letters += self._habitual("glides", tables["glides"])
                usual = tables["vowels"][sound.letter]
                weights = tables["final_vowels"].get(sound.letter, usual) if is_last else usual
                letters += self._habitual(f"{sound.letter}{is_last}", weights)
        return letters

    def _habitual(self, name: str, weights: Weights) -> str:
        """Return the writer's usual spelling, or now and then another."""
        if name not in self._habits:
            self._habits[name] = draw(weights, self.random)
        return self._habits[name] if self.random.random() < _HABIT else draw(weights, self.random)


def _sounds(word: str) -> Iterator[_Sound]:
    """Yield a word's sounds without silent vowels."""
    sounds: list[_Sound] = []
    at = 0
    while at < len(word):
        size = 2 if word[at + 1 : at + 2] == _DOT else 1
        letter, following = word[at : at + size], word[at + size : at + size + 1]
        at += size
        if letter in _INDEPENDENT:
            sounds.append(_Sound(letter, "vowel"))
        elif letter in _NASALS:
            sounds.append(_Sound(letter, "nasal"))
        elif letter in _VOWEL_OF_SIGN:
            sounds.append(_Sound(_VOWEL_OF_SIGN[letter], "vowel"))
        elif letter in spellings()["letters"]:
            sounds.append(_Sound(letter, "consonant"))
            if following not in (_VIRAMA, *_VOWEL_OF_SIGN):
                sounds.append(_Sound("", "vowel"))
    yield from (sound for number, sound in enumerate(sounds) if not _is_silent(sounds, number))


def _is_silent(sounds: list[_Sound], at: int) -> bool:
    """Return whether an inherent vowel is silent: at the end, and before a consonant between two vowels."""
    if sounds[at].letter or sounds[at].kind != "vowel":
        return False
    if at + 1 == len(sounds):
        return sum(sound.kind == "vowel" for sound in sounds) > 1
    before = at >= 2 and sounds[at - 2].kind == "vowel"
    after = (at + 2 < len(sounds) and sounds[at + 1].kind == "consonant" and sounds[at + 2].kind == "vowel") and sounds[
        at + 2
    ].letter != ""
    return before and after
