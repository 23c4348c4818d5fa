"""Initial vocabulary and word embeddings of `vl_grounded`, from the learned reader or from weights to fine-tune."""

from collections.abc import Iterable, Mapping

import torch
from torch import Tensor

from arramon_agents.reading.reader.network import ReaderNetwork
from arramon_agents.reading.reader.vocabulary import Vocabulary
from arramon_agents.reading.tokenizers import SPECIAL, UNKNOWN, PolicyWordTokenizer
from arramon_agents.vl_grounded.instruction_encoder import InstructionEncoder
from arramon_agents.vl_grounded.network import Grounded, GroundedWeights

EMBEDDING = "reading.words.weight"
"""Tensor name of the word embeddings."""

SHARED = ("phrases", "encoder")
"""Names of the modules that are initialised from the reader's network."""


def tokenizer_with_reader(texts: Iterable[str], reader: Vocabulary) -> PolicyWordTokenizer:
    """Return a tokenizer with the words that occur at least twice in the texts, and the words of a reader."""
    return PolicyWordTokenizer(sorted({*PolicyWordTokenizer.train(texts).vocabulary, *reader.words}))


def extended_weights(known: GroundedWeights, texts: Iterable[str]) -> tuple[PolicyWordTokenizer, Grounded]:
    """Extend weights to fine-tune by the words that occur at least twice in the texts; return tokenizer and network.

    A new word gets the embedding of the unknown word.

    Raises:
        ValueError: if the weights have another tokenizer.
    """
    if not isinstance(known.tokenizer, PolicyWordTokenizer):
        raise ValueError(f"weights to begin with have the tokenizer {known.tokenizer.name!r}, expected 'word'")
    words = known.tokenizer.with_new_words(texts)
    network, values = Grounded(words.size), known.network.state_dict()
    own = values[EMBEDDING]
    added = own[UNKNOWN].repeat(words.size - len(own), 1)
    network.load_state_dict(values | {EMBEDDING: torch.cat([own, added])})
    return words, network


def initialise_from_reader(
    reading: InstructionEncoder, words: PolicyWordTokenizer, network: ReaderNetwork, vocabulary: Vocabulary
) -> None:
    """Initialise a text encoder from the reader's network; words that the reader does not know keep their embeddings.

    Args:
        reading: the text encoder, changed in place.
        words: tokenizer of the text encoder.
        network, vocabulary: network and vocabulary of the reader.

    Raises:
        ValueError: if the reader has another embedding size.
    """
    given: Mapping[str, Tensor] = network.state_dict()
    own = reading.state_dict()
    known = set(vocabulary.words)
    embedding = own["words.weight"].clone()
    if embedding.shape[1] != given["words.weight"].shape[1]:
        raise ValueError(f"a reader's words have {given['words.weight'].shape[1]} numbers, not {embedding.shape[1]}")
    with torch.no_grad():
        embedding[UNKNOWN] = network.embed_words(torch.tensor(vocabulary.code("")))
        for number, word in enumerate(words.vocabulary, start=SPECIAL):
            if word in known:
                embedding[number] = network.embed_words(torch.tensor(vocabulary.code(word)))
    copied = {name: value.clone() for name, value in given.items() if name.split(".")[0] in SHARED}
    with torch.no_grad():
        reading.load_state_dict(own | copied | {"words.weight": embedding})
