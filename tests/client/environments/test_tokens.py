"""Instructions as padded numbers."""

import numpy as np

from arramon_client.environments.tokens import ByteTokenizer, WordTokenizer


def test_bytes_are_numbered_as_in_byt5() -> None:
    tokenizer = ByteTokenizer(6)
    assert tokenizer.encode("Go").tolist() == [ord("G") + 3, ord("o") + 3, 1, 0, 0, 0, 0]
    assert tokenizer.encode("लघु").dtype == np.int32
    assert tokenizer.encode("ल").tolist()[:4] == [0xE0 + 3, 0xA4 + 3, 0xB2 + 3, 1]
    assert tokenizer.encode("longer than six").tolist()[-1] == 1  # cut off, and ended


def test_a_vocabulary() -> None:
    tokenizer = WordTokenizer.of(["Go left.", "go right"])
    assert tokenizer.vocabulary == (".", "go", "left", "right")
    assert (tokenizer.size, tokenizer.length) == (7, 4)
    assert tokenizer.encode("Go north.").tolist() == [4, 2, 3, 1]
    assert tokenizer.name == WordTokenizer.of(["go right left ."]).name
    assert tokenizer.name != WordTokenizer.of(["go right left"]).name
