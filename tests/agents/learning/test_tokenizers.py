"""Tokenizers: Devanagari stays whole, what was dumped comes back, unknown words have a number."""

import pytest

from agents.learning.tokenizers import UNKNOWN, SentencePieces, Tokenizer, Words, restore_tokenizer, train_tokenizer

TEXTS = ["Turn left and walk to the bench.", "बाएँ मुड़ें और बेंच तक जाएँ।", "Walk to the bench.", "बेंच तक जाएँ।"]


def test_words_of_hindi_stay_whole() -> None:
    tokenizer = Words.train(TEXTS, least=1)
    assert {"बाएँ", "मुड़ें", "बेंच", "जाएँ", "।"} <= set(tokenizer.vocabulary)


def test_one_spelling_one_number() -> None:
    tokenizer = Words.train(["लड़का"], least=1)
    assert tokenizer.encode("लड\u093cका") == tokenizer.encode("ल\u095cका") == tokenizer.encode("लड़\u200dका") == [2]


def test_rare_and_unknown_words() -> None:
    tokenizer = Words.train(TEXTS)
    assert tokenizer.encode("Walk north") == [tokenizer.encode("walk")[0], UNKNOWN]
    assert tokenizer.encode("") == [UNKNOWN]


@pytest.mark.parametrize("name", ["word", "sentencepiece"])
def test_dumped_and_restored(name: str) -> None:
    made = train_tokenizer(name, TEXTS * 20)
    again: Tokenizer = restore_tokenizer(name, made.dump())
    assert again.size == made.size
    for text in [*TEXTS, "नया शब्द", "new word"]:
        assert again.encode(text) == made.encode(text)
        assert all(0 < number < made.size for number in made.encode(text))


def test_sentencepiece_has_no_more_pieces_than_it_can_find() -> None:
    assert SentencePieces.train(TEXTS * 20, pieces=5000).size < 200


def test_an_unknown_name_is_told() -> None:
    with pytest.raises(ValueError, match="there is no tokenizer 'char'; there are word, sentencepiece, xlmr"):
        train_tokenizer("char", TEXTS)
    with pytest.raises(ValueError, match="xlmr=FOLDER"):
        train_tokenizer("xlmr", TEXTS)
