"""Public interface of the package: a language, loaded from its data folder."""

import os
import re
from collections.abc import Callable, Mapping
from functools import cache, cached_property, lru_cache
from pathlib import Path
from random import Random
from typing import Any

from arramon_lang.files import read_file
from arramon_lang.grammar import Grammar
from arramon_lang.lexicon import Lexicon
from arramon_lang.meaning import Meaning
from arramon_lang.reading.mentions import Mention, find_mentions
from arramon_lang.reading.outline import OutlineEntry
from arramon_lang.reading.parser import InstructionParser
from arramon_lang.reading.relations import Relations
from arramon_lang.reading.scripts.reader import SecondScriptReader
from arramon_lang.tokens import LATIN, ScriptTokenizer, Token
from arramon_lang.writing.preferences import Preferences
from arramon_lang.writing.voice import Manner, Voice, draw_voice
from arramon_lang.writing.writer import Writer

ROOT = Path(__file__).parent
"""Folder that contains the languages' folders."""

FURTHER = "ARRAMON_LANGUAGES"
"""Environment variable that names a folder with the folders of further languages, found beside those of ROOT."""

CACHED_READINGS = 64
"""Number of cached readings of texts."""

_ABOUT = "language.toml"

_GRAMMAR = ("grammar", "things", "phrases")
"""Files of `Language.grammar`."""


class UnknownLanguage(LookupError):
    """The language has no folder; the message lists the available ones."""


class Language:
    """One language: its names, and methods that analyse, read and write its texts.

    Args:
        folder: contains `language.toml`, `lexicon.toml`, `relations.toml`, `grammar.toml`, `things.toml` and
            `phrases.toml`, all described in those of `lang/en`; possibly `chunks.toml`, `latin.toml` and
            `typing.toml`, described in their own comments.

    Attributes:
        code: name of the folder, such as "hi".
        name: name in the language itself, such as "हिन्दी".
        english_name: name in English, such as "Hindi".
        script: name of the script, such as "Devanagari".
        required: whether every generated episode has this language. Others are written on request only, and an episode
            that such a language cannot express lacks it.
        preview: whether the language is published for trial, before native speakers have reviewed it.

    Raises:
        ValueError: if a file's content does not have the documented format.
    """

    def __init__(self, folder: Path) -> None:
        about = read_file(folder, "language")
        self.code: str = about["code"]
        self.name: str = about["name"]
        self.english_name: str = about["english_name"]
        self.script: str = about["script"]
        self.required: bool = about.get("required", False)
        self.preview: bool = about.get("preview", False)
        if self.code != folder.name:
            raise ValueError(f"{folder / _ABOUT}: code {self.code!r}; expected the folder's name, {folder.name!r}")
        self._folder = folder
        self._spelt_with = {ord(character): None for character in about.get("spelt_with", "")}
        self._tokenizer = ScriptTokenizer(about["letters"], about["digits"], about["ignored"])
        self._words = read_file(folder, "lexicon")
        self._lexicon = Lexicon(self._words, self._tokenizer)
        self._relation_words = read_file(folder, "relations")
        self._relations = Relations(self._relation_words, self._tokenizer, self._lexicon)

    def normalise(self, text: str) -> str:
        """Return the text in Unicode's NFC, without characters that carry no meaning, with single spaces."""
        return self._tokenizer.normalise(text)

    def without_spelt_joiners(self, text: str) -> str:
        """Return the text without the ignored characters that correct spelling uses, such as Telugu's non-joiner."""
        return text.translate(self._spelt_with)

    def tokenize(self, text: str) -> list[str]:
        """Return the text's words, numbers and punctuation in order, normalised, with their case."""
        return [token.text for token in self._tokenizer.split(text)]

    def split(self, text: str) -> list[Token]:
        """Return the text's words, numbers and punctuation in order, normalised, with their positions in `text`."""
        return self._tokenizer.split(text)

    def find_objects(self, text: str) -> list[Mention]:
        """Return the collectibles that a text mentions, in order, with their positions in `text` as given.

        Attributes may be in any order and words in any case; words of five or more letters may have one typing error.
        """
        return find_mentions(self._tokenizer.split(text), self._lexicon)

    def relation_of(self, text: str, mention: Mention) -> str | None:
        """Return the relation whose landmark is a mentioned object.

        Args:
            text: in which the mention was found.
            mention: from `find_objects(text)`.

        Returns:
            "on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near" or "against"; None if the
            object is not a landmark.
        """
        return self._relations.of(self._tokenizer.split(text), mention)

    def write(self, meaning: Meaning, random: Random, voice: Voice | None = None) -> str:
        """Return an instruction that expresses the meaning; a deterministic function of the arguments.

        Args:
            meaning: content to express.
            random: source of all random choices.
            voice: from `draw_voice`, to write several texts as one speaker; None to draw one for this text.

        Raises:
            ValueError: if the language cannot express some part of it.
        """
        return self._writer.write(meaning, random, voice)

    def draft(self, meaning: Meaning, random: Random, voice: Voice) -> str:
        """Return a text that expresses the meaning in the first words that come: in a fifth of the time of `write`.

        Args:
            meaning, random, voice: as for `write`.

        Raises:
            ValueError: as `write` does.
        """
        return self._writer.draft(meaning, random, voice)

    def draw_voice(self, random: Random, manner: Manner | None = None) -> Voice:
        """Draw a speaker, whose register, nouns and habits stay the same in all texts; the manner is drawn if None."""
        return draw_voice(self.grammar, random, manner)

    @property
    def has_grammar(self) -> bool:
        """Whether the language has the files to read and write meanings; without them its texts can only be checked."""
        return all((self._folder / f"{name}.toml").exists() for name in _GRAMMAR)

    @cached_property
    def grammar(self) -> Grammar:
        """The language's data for writing and reading, loaded on first use."""
        return Grammar(*(read_file(self._folder, name) for name in _GRAMMAR))

    @cached_property
    def _writer(self) -> Writer:
        exists = (self._folder / "preferences.toml").exists()
        return Writer(self.grammar, Preferences(read_file(self._folder, "preferences")) if exists else None)

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of an instruction; parts that are not understood are skipped.

        Args:
            text: the instruction.
            phase: "navigation", which returns an `arramon_lang.meaning.Navigation`, or "assembly", an `Assembly`.

        Raises:
            ValueError: if the phase is unknown.
            CannotRead: a ValueError, if no part of the text is understood.
        """
        return self._reading(text, phase)

    def reads_whole(self, text: str, phase: str) -> bool:
        """Return whether `read` skips no word of a text that matters; false for texts that it reads by foreign words.

        Args:
            text, phase: as for `read`.
        """
        is_foreign = re.search(f"[{LATIN}]", text) is not None and self.second_script is not None
        return not is_foreign and self.parser.reads_whole(text, phase)

    def outline(self, text: str) -> tuple[OutlineEntry, ...]:
        """Return the turns of a navigation instruction and every thing that it mentions, in order.

        The outline is empty if no part of the text is understood.
        """
        return self._reader.outline(text)

    @cached_property
    def parser(self) -> InstructionParser:
        """The parser of texts in the language's own script."""
        return InstructionParser(
            self.grammar,
            self._words,
            self._relation_words,
            self._tokenizer,
            self._optional_file("chunks"),
            self._optional_file("typing"),
        )

    @cached_property
    def second_script(self) -> SecondScriptReader | None:
        """The reader of texts in Latin letters and with words of another language; None without a `latin.toml`."""
        data = self._optional_file("latin")
        if data is None:
            return None
        return SecondScriptReader(self.parser, data, load(data["borrows"], self._folder.parent).parser)

    @property
    def _reader(self) -> InstructionParser | SecondScriptReader:
        return self.second_script or self.parser

    def _optional_file(self, name: str) -> Mapping[str, Any] | None:
        return read_file(self._folder, name) if (self._folder / f"{name}.toml").exists() else None

    @cached_property
    def _reading(self) -> Callable[[str, str], Meaning]:
        """Cached reading: both the tester and the follower read each tested instruction."""
        return lru_cache(maxsize=CACHED_READINGS)(self._reader.read)

    def count_words(self, text: str) -> int:
        """Return the number of the text's words that the language knows; 0 if it has no grammar."""
        if not self.has_grammar:
            return 0
        words = (word for key in self.parser.split(text) for word in self.parser.expand(key))
        return sum(word in self.parser.vocabulary for word in words if word[0].isalpha())

    def count_latin_words(self, text: str) -> int:
        """Return the number of words that the language understands in a text in Latin letters.

        It is 0 for texts in other letters, of other languages, and if the language is written in one script only.
        """
        if re.search(f"[{LATIN}]", text) is None or self.second_script is None:
            return 0
        return self.second_script.count_words(text)

    def count_letters(self, text: str) -> int:
        """Return the number of characters of the text that belong to the language's script."""
        return self._tokenizer.count_letters(text)

    def is_in_own_script(self, text: str) -> bool:
        """Return whether at least half of a text's letters belong to the language's own script."""
        return 2 * self.count_letters(text) >= sum(map(str.isalpha, text))


def available(root: Path = ROOT) -> tuple[str, ...]:
    """Return the codes of all languages, sorted: every folder with a `language.toml`."""
    return tuple(sorted({path.parent.name for folder in _roots(root) for path in folder.glob(f"*/{_ABOUT}")}))


def language_folder(code: str, root: Path = ROOT) -> Path:
    """Return the folder of a language; the one in which it would be expected if there is none."""
    folders = [folder / code for folder in _roots(root)]
    return next((folder for folder in folders if (folder / _ABOUT).exists()), folders[0])


def _roots(root: Path) -> tuple[Path, ...]:
    further = os.environ.get(FURTHER, "") if root == ROOT else ""
    return (root, Path(further)) if further else (root,)


def required(root: Path = ROOT) -> tuple[str, ...]:
    """Return the codes of the languages that every generated episode has, sorted: `required` in `language.toml`."""
    return tuple(code for code in available(root) if load(code, root).required)


@cache
def load(code: str, root: Path = ROOT) -> Language:
    """Return the language with that code, loaded once.

    Raises:
        UnknownLanguage: if no folder has that code.
    """
    codes = available(root)
    if code not in codes:
        raise UnknownLanguage(f"no language {code!r}; there are {', '.join(codes)}")
    return Language(language_folder(code, root))


def identify(text: str, root: Path = ROOT) -> str:
    """Return the code of the language that a text is written in.

    The script of most of its letters decides. Among languages that share a script, the one that finds the most
    collectibles in the text is chosen; but a language that is also written in this script (`latin.toml`) if it
    understands more words than that one.

    Raises:
        ValueError: if no letter of the text belongs to a known language.
    """
    languages = [load(code, root) for code in available(root)]
    most = max(language.count_letters(text) for language in languages)
    if most == 0:
        raise ValueError(f"{text[:60]!r} is in none of {', '.join(language.code for language in languages)}")
    fitting = [language for language in languages if language.count_letters(text) == most]
    best = max(fitting, key=lambda language: len(language.find_objects(text)))
    others = [language for language in languages if language not in fitting and language.count_latin_words(text)]
    further = max(others, key=lambda language: language.count_latin_words(text), default=best)
    return further.code if further.count_latin_words(text) > best.count_words(text) else best.code
