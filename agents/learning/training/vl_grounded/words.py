"""The words with which `vl_grounded` begins to learn: those of the learned reader, as that network knows them."""

from collections.abc import Iterable, Mapping

import torch
from torch import Tensor

from agents.learning.reader.network import ReaderNetwork
from agents.learning.reader.words import Vocabulary
from agents.learning.text.tokenizers import SPECIAL, UNKNOWN, Words
from agents.vl_grounded.reading import Reading

SHARED = ("phrases", "encoder")
"""Parts of a reader's network that begin as they are there."""


def known_words(texts: Iterable[str], reader: Vocabulary) -> Words:
    """Return a tokenizer that knows the words of texts that occur twice, and those of a reader."""
    return Words(sorted({*Words.train(texts).vocabulary, *reader.words}))


def begin(reading: Reading, words: Words, network: ReaderNetwork, vocabulary: Vocabulary) -> None:
    """Let a network read as a reader's does; what the reader does not know stays as it is.

    Args:
        reading: changed.
        words: numbers of its words.
        network, vocabulary: of the reader.

    Raises:
        ValueError: if the reader has other sizes.
    """
    given: Mapping[str, Tensor] = network.state_dict()
    own = reading.state_dict()
    numbers = {word: number for number, word in enumerate(vocabulary.words, start=UNKNOWN + 1)}
    embedding = own["words.weight"].clone()
    if embedding.shape[1] != given["words.weight"].shape[1]:
        raise ValueError(f"a reader's words have {given['words.weight'].shape[1]} numbers, not {embedding.shape[1]}")
    embedding[UNKNOWN] = given["words.weight"][UNKNOWN]
    for number, word in enumerate(words.vocabulary, start=SPECIAL):
        if word in numbers:
            embedding[number] = given["words.weight"][numbers[word]]
    copied = {name: value.clone() for name, value in given.items() if name.split(".")[0] in SHARED}
    with torch.no_grad():
        reading.load_state_dict(own | copied | {"words.weight": embedding})
