"""What counts as a word here: a token of the language's own tokenizer with a letter or digit in it, in one case."""

from lang import Language


def words_of(language: Language, text: str) -> tuple[str, ...]:
    """The text's words in order: punctuation left out, "STOP" the same as "stop"."""
    return tuple(
        token.casefold() for token in language.tokenize(text) if any(character.isalnum() for character in token)
    )
