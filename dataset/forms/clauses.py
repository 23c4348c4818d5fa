"""Hinglish that changes the language between sentences: some in English, the others in romanised Hindi."""

import re
from dataclasses import dataclass
from random import Random

from arramon_dataset.forms.mixed import VERBS, hinglish
from arramon_lang import CannotRead, Language
from arramon_lang.meaning import Assembly, Meaning, Navigation, Step
from arramon_lang.writing.voice import Voice

_ATTEMPTS = 8
"""Number of pairs of texts that are written before a text in one language is accepted."""

_SENTENCES = re.compile(r"(?<=[.।!?])\s+")


@dataclass(frozen=True, slots=True)
class Bilingual:
    """A speaker of English and Hindi.

    Attributes:
        english, hindi: the languages.
        voices: of the speaker in English and in Hindi.
        random: source of all choices.
    """

    english: Language
    hindi: Language
    voices: tuple[Voice, Voice]
    random: Random

    def write(self, meaning: Meaning) -> str:
        """Return a text that changes the language at a point where both languages' texts have told the same steps."""
        if isinstance(meaning, Assembly):
            return self._either(meaning)
        for _ in range(_ATTEMPTS):
            english = _SENTENCES.split(self.english.write(meaning, self.random, self.voices[0]))
            hindi = _SENTENCES.split(self.hindi.write(meaning, self.random, self.voices[1]))
            ends = _steps_told(english, self.english, meaning)
            common = [
                (at, told) for at, told in _steps_told(hindi, self.hindi, meaning).items() if told in ends.values()
            ]
            if common:
                at, told = self.random.choice(common)
                other = next(n for n, steps in ends.items() if steps == told)
                if self.random.random() < 0.5:
                    return " ".join((*english[:other], self._mixed(hindi[at:])))
                return " ".join((self._mixed(hindi[:at]), *english[other:]))
        return self._either(meaning)

    def _either(self, meaning: Meaning) -> str:
        if self.random.random() < 0.5:
            return self.english.write(meaning, self.random, self.voices[0])
        return self._mixed([self.hindi.write(meaning, self.random, self.voices[1])])

    def _mixed(self, sentences: list[str]) -> str:
        return hinglish(" ".join(sentences), VERBS, self.random)


def _steps_told(sentences: list[str], language: Language, meaning: Navigation) -> dict[int, int]:
    """Return how many steps the first sentences tell, by their number, where they tell whole steps and no target."""
    told: dict[int, int] = {}
    for number in range(1, len(sentences)):
        steps = _steps(" ".join(sentences[:number]), language)
        if steps and steps == meaning.steps[: len(steps)]:
            told[number] = len(steps)
    return told


def _steps(text: str, language: Language) -> tuple[Step, ...]:
    try:
        meaning = language.read(text, "navigation")
    except CannotRead:
        return ()
    return meaning.steps if isinstance(meaning, Navigation) and not meaning.target.kind else ()
