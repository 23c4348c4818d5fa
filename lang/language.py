"""A language as the rest of the project sees it, read from its folder of data."""

import tomllib
from collections.abc import Callable, Mapping
from functools import cache, cached_property, lru_cache
from pathlib import Path
from random import Random
from typing import Any

from lang.grammar import Grammar
from lang.lexicon import Lexicon
from lang.meaning import Meaning
from lang.mentions import Mention, find_mentions
from lang.reading import Reader
from lang.relations import Relations
from lang.tokens import Tokenizer
from lang.writing import Writer

ROOT = Path(__file__).parent
"""Where the languages' folders lie."""

KEPT = 64
"""Texts whose meaning is kept after they were read."""

_ABOUT = "language.toml"


class UnknownLanguage(LookupError):
    """There is no folder for the language; the message names it and those that there are."""


class Language:
    """One language: its names, and what can be read in its texts.

    Args:
        folder: with `language.toml`, `lexicon.toml`, `relations.toml`, `grammar.toml`, `things.toml` and
            `phrases.toml`, all described in those of `lang/en`.

    Attributes:
        code: such as "hi"; the folder's name.
        name: in itself, such as "हिन्दी".
        english_name: such as "Hindi".
        script: such as "Devanagari".

    Raises:
        ValueError: if a file's content is not as described.
    """

    def __init__(self, folder: Path) -> None:
        about = _read(folder / _ABOUT)
        self.code: str = about["code"]
        self.name: str = about["name"]
        self.english_name: str = about["english_name"]
        self.script: str = about["script"]
        if self.code != folder.name:
            raise ValueError(f"{folder / _ABOUT}: code {self.code!r}; expected the folder's name, {folder.name!r}")
        self._folder = folder
        self._tokenizer = Tokenizer(about["letters"], about["digits"], about["ignored"])
        self._words = _read(folder / "lexicon.toml")
        self._lexicon = Lexicon(self._words, self._tokenizer)
        self._relation_words = _read(folder / "relations.toml")
        self._relations = Relations(self._relation_words, self._tokenizer, self._lexicon)

    def normalise(self, text: str) -> str:
        """The text in Unicode's NFC, without characters that carry no meaning, each run of white space one space."""
        return self._tokenizer.normalise(text)

    def tokenize(self, text: str) -> list[str]:
        """The text's words, numbers and marks in order, normalised, in the case they were written in."""
        return [token.text for token in self._tokenizer.split(text)]

    def find_objects(self, text: str) -> list[Mention]:
        """The collectibles that a text mentions, in order; their places are those in `text` as given.

        Attributes may stand in any order, words in any case, and words of five or more letters may have one wrong.
        """
        return find_mentions(self._tokenizer.split(text), self._lexicon)

    def relation_of(self, text: str, mention: Mention) -> str | None:
        """The relation in which a mentioned object serves as the landmark.

        Args:
            text: the one that the mention was found in.
            mention: one that `find_objects(text)` gave.

        Returns:
            "on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near" or "against"; None if the
            object is the landmark of nothing.
        """
        return self._relations.of(self._tokenizer.split(text), mention)

    def write(self, meaning: Meaning, random: Random) -> str:
        """An instruction that says the meaning; it depends on the two arguments alone.

        Raises:
            ValueError: for something that the language has no words for.
        """
        return self._writer.write(meaning, random)

    @cached_property
    def grammar(self) -> Grammar:
        """What the language's files hold for writing and reading; read when it is first needed."""
        return Grammar(*(_read(self._folder / f"{name}.toml") for name in ("grammar", "things", "phrases")))

    @cached_property
    def _writer(self) -> Writer:
        return Writer(self.grammar)

    def read(self, text: str, phase: str) -> Meaning:
        """What an instruction means, as far as it is understood; what is not is skipped.

        Args:
            text: the instruction.
            phase: "navigation", which gives a `lang.meaning.Navigation`, or "assembly", which gives an `Assembly`.

        Raises:
            ValueError: for another phase.
            CannotRead: a ValueError, if nothing of the text is understood.
        """
        return self._reading(text, phase)

    @cached_property
    def _reading(self) -> Callable[[str, str], Meaning]:
        """Keeps what it has read of late: an instruction that is tried is read by whoever tries and whoever follows."""
        return lru_cache(maxsize=KEPT)(Reader(self.grammar, self._words, self._relation_words, self._tokenizer).read)

    def count_letters(self, text: str) -> int:
        """How many characters of the text belong to the language's script."""
        return self._tokenizer.count_letters(text)


def available(root: Path = ROOT) -> tuple[str, ...]:
    """The codes of the languages that there are, in alphabetical order: every folder with a `language.toml`."""
    return tuple(sorted(path.parent.name for path in root.glob(f"*/{_ABOUT}")))


@cache
def load(code: str, root: Path = ROOT) -> Language:
    """The language of that code; one object for all who ask.

    Raises:
        UnknownLanguage: if there is none.
    """
    codes = available(root)
    if code not in codes:
        raise UnknownLanguage(f"no language {code!r}; there are {', '.join(codes)}")
    return Language(root / code)


def identify(text: str, root: Path = ROOT) -> str:
    """The code of the language that a text is in, by the script that most of its letters belong to.

    Languages that share a script are told apart by how many collectibles they find in the text.

    Raises:
        ValueError: if no letter of it belongs to a language that there is.
    """
    languages = [load(code, root) for code in available(root)]
    most = max(language.count_letters(text) for language in languages)
    if most == 0:
        raise ValueError(f"{text[:60]!r} is in none of {', '.join(language.code for language in languages)}")
    fitting = [language for language in languages if language.count_letters(text) == most]
    return max(fitting, key=lambda language: len(language.find_objects(text))).code


def _read(path: Path) -> Mapping[str, Any]:
    with path.open("rb") as file:
        return tomllib.load(file)
