"""Words of a text: case-folded tokens of the language's tokenizer that contain a letter or digit."""

from arramon_lang import Language


def words_of(language: Language, text: str) -> tuple[str, ...]:
    """Return the text's words in order, without punctuation and case-folded ("STOP" equals "stop")."""
    return tuple(
        token.casefold() for token in language.tokenize(text) if any(character.isalnum() for character in token)
    )
