"""The forms of texts that people type, and the writing of an episode's texts in one of them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from random import Random

import arramon_lang as lang
from arramon_dataset.forms.clauses import Bilingual
from arramon_dataset.forms.colloquial import colloquial
from arramon_dataset.forms.mixed import NOUNS, VERBS, hinglish, with_loans
from arramon_dataset.forms.romaniser import Romaniser
from arramon_dataset.forms.terse import TerseWriter, terse_hindi
from arramon_dataset.forms.typing_errors import with_typing_errors
from arramon_dataset.randomness import seeded
from arramon_lang.meaning import Meaning, Navigation, Walk
from arramon_lang.writing.voice import Voice
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.errors import BadInput, quoted

FORMS: Mapping[str, tuple[str, ...]] = {
    "paraphrased": ("en", "hi"),
    "terse": ("en", "hi"),
    "typing": ("en",),
    "romanised": ("hi",),
    "hinglish_nouns": ("hi",),
    "hinglish_verbs": ("hi",),
    "hinglish_clauses": ("hi",),
    "loans": ("hi",),
}
"""Languages that have each form."""

PHASES = ("navigation", "assembly")


@dataclass(frozen=True, slots=True)
class FormWriter:
    """Writer of the texts of one episode in one form and language: one person's.

    Attributes:
        form: one of `FORMS`.
        language: code.
        random: source of all choices.
        voices: the person's voices, by language.
    """

    form: str
    language: str
    random: Random
    voices: Mapping[str, Voice]

    def write(self, text: str, phase: str) -> str:
        """Return another text with the meaning of `text`, in the form.

        Raises:
            CannotRead: if the text's meaning is needed, and nothing of it is understood.
        """
        if self.form == "typing":
            return with_typing_errors(text, self.random)
        if self.form == "romanised":
            return Romaniser(self.random).text(text)
        if self.form in ("hinglish_nouns", "hinglish_verbs"):
            return hinglish(text, NOUNS if self.form == "hinglish_nouns" else VERBS, self.random)
        if self.form == "loans":
            return with_loans(text, self.random)
        if self.form == "terse" and self.language == "hi":
            return terse_hindi(text, phase)
        return self._from_meaning(lang.load(self.language).read(text, phase))

    def _from_meaning(self, meaning: Meaning) -> str:
        if self.form == "terse":
            return TerseWriter(self.random, self.random.choice((", ", "; ", ". "))).write(meaning)
        # A text does not say of all its things whether they are straight ahead: none is, if it can be said so.
        try:
            return self._written(_not_straight(meaning))
        except ValueError:
            return self._written(meaning)

    def _written(self, meaning: Meaning) -> str:
        language = lang.load(self.language)
        if self.form == "hinglish_clauses":
            voices = self.voices["en"], self.voices["hi"]
            return Bilingual(lang.load("en"), language, voices, self.random).write(meaning)
        return colloquial(language.write(meaning, self.random, self.voices[self.language]), self.language, self.random)


def _not_straight(meaning: Meaning) -> Meaning:
    if not isinstance(meaning, Navigation):
        return meaning
    steps = (
        replace(step, straight=False) if isinstance(step, Walk) and step.things else step for step in meaning.steps
    )
    return replace(meaning, steps=tuple(steps))


def draw_voices(language: str, random: Random) -> dict[str, Voice]:
    """Draw the voices of one person who writes in a language: in it, and in English if its forms mix the two."""
    codes = (language, "en") if language == "hi" else (language,)
    return {code: lang.load(code).draw_voice(random) for code in codes}


def check_form(form: str, language: str) -> None:
    """Check that a language has a form.

    Raises:
        BadInput: if the form is unknown, or the language does not have it.
    """
    if form not in FORMS:
        raise BadInput(f"unknown form {quoted(form)}; expected one of {', '.join(FORMS)}")
    if language not in FORMS[form]:
        having = ", ".join(each for each, codes in FORMS.items() if language in codes)
        found = f"it has {having}" if having else f"forms exist in {', '.join(sorted({*sum(FORMS.values(), ())}))}"
        raise BadInput(f"language {quoted(language)} has no form {form}; {found}")


def episode_in_form(episode: Episode, form: str, language: str, seed: int) -> Episode | None:
    """Return an episode with its texts of one language in a form, and no others; None if it lacks the language.

    The same arguments give the same texts. An episode's texts are one person's.

    Raises:
        BadInput: if a text whose meaning is needed cannot be read; names the episode.
    """
    if language not in episode.instructions:
        return None
    random = seeded(seed, form, language, episode.episode_id)
    voices = draw_voices(language, random)
    writer = FormWriter(form, language, random, voices)
    try:
        first, second = (
            Instructions(*(writer.write(getattr(texts, phase), phase) for phase in PHASES))
            for texts in episode.instructions[language]
        )
    except lang.CannotRead as error:
        raise BadInput(
            f"episode {quoted(episode.episode_id)} cannot be written as {form}: {error}; expected generated texts"
        ) from error
    return replace(episode, instructions={language: (first, second)})
