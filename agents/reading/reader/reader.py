"""The learned reader at play: from instructions to meanings; saving and loading its network."""

from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import torch

from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.slots import END, SLOTS, TYPES, Row, meaning_of
from arramon_agents.reading.reader.vocabulary import Vocabulary
from arramon_agents.weights import read_weights_file, write_weights_file
from arramon_lang.meaning import Meaning

WEIGHTS = Path(__file__).with_name("weights.safetensors")

FORMAT = "reader 2"

CACHED = 512
"""Number of texts whose rows are cached."""


class LearnedReader:
    """Parses instructions to meanings, in any language of its training; the language need not be given.

    Args:
        network: trained network, in evaluation mode.
        vocabulary: vocabulary of the network.
    """

    def __init__(self, network: ReaderNetwork, vocabulary: Vocabulary) -> None:
        self._network, self._vocabulary = network, vocabulary
        self._rows = lru_cache(CACHED)(self._read)

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of an instruction, without inconsistent parts.

        Args:
            text: the instruction.
            phase: "navigation" for a `arramon_lang.meaning.Navigation`, "assembly" for an `Assembly`.
        """
        return meaning_of(self._rows(text), phase)

    def _read(self, text: str) -> tuple[Row, ...]:
        rows = self._network.read(torch.tensor([self._vocabulary.encode(text)]))[0].tolist()
        end, place = TYPES.index(END), list(SLOTS).index("type")
        ends = [number for number, row in enumerate(rows) if row[place] == end]
        return tuple(tuple(row) for row in rows[: ends[0] if ends else len(rows)])


def write_reader(path: Path, network: ReaderNetwork, vocabulary: Vocabulary) -> None:
    """Write a reader to a file, atomically."""
    header = {"format": FORMAT, "sizes": asdict(network.sizes), "words": vocabulary.words}
    write_weights_file(path, {"": network}, header)


def read_reader(path: Path) -> tuple[ReaderNetwork, Vocabulary]:
    """Return a reader's network, in evaluation mode, and its vocabulary.

    Raises:
        BadWeights: if there is no such file, or it holds no reader.
    """
    file = read_weights_file(path, "the learned reader", FORMAT, None)
    words = file.value("words", list)
    if not all(isinstance(word, str) for word in words):
        raise file.wrong("its header has 'words' that are no texts")
    sizes = file.sizes("sizes", ReaderSizes)
    network = file.build(lambda: ReaderNetwork(sizes))
    file.fill(network)
    network.requires_grad_(requires_grad=False)
    return network, Vocabulary(words)


def load(source: Path | None = None) -> LearnedReader:
    """Return the reader with the shipped weights, or those of a file.

    Raises:
        BadWeights: if there is no such file, or it holds no reader.
    """
    return LearnedReader(*read_reader(source or WEIGHTS))
