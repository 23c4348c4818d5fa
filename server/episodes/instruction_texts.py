"""Alphabet and lengths of the instruction texts of episodes."""

from collections.abc import Iterable
from dataclasses import dataclass

from arramon_server.episodes.episode import Episode


@dataclass(frozen=True, slots=True)
class TextSummary:
    """Alphabet and lengths of the instructions in one language.

    Attributes:
        alphabet: all characters that occur, sorted.
        longest: length of the longest instruction, in characters.
        longest_utf8: length of the longest instruction in UTF-8, in bytes.
    """

    alphabet: str
    longest: int
    longest_utf8: int

    @classmethod
    def of(cls, instructions: Iterable[str]) -> "TextSummary":
        """Return the summary of some texts."""
        texts = list(instructions)
        return cls(
            alphabet="".join(sorted(set().union(*texts))),
            longest=max(map(len, texts), default=0),
            longest_utf8=max((len(text.encode()) for text in texts), default=0),
        )


def instructions_in(episodes: Iterable[Episode], language: str) -> list[str]:
    """Return every instruction of the episodes in a language, in order."""
    return [
        text
        for episode in episodes
        for turn in episode.instructions.get(language, ())
        for text in (turn.navigation, turn.assembly)
    ]


def texts_by_language(episodes: Iterable[Episode]) -> dict[str, TextSummary]:
    """Return the summary of each language's instructions, by code."""
    listed = list(episodes)
    languages = sorted({language for episode in listed for language in episode.instructions})
    return {language: TextSummary.of(instructions_in(listed, language)) for language in languages}
